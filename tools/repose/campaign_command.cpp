// repose campaign: many runs of a scenario, none done twice, none lost.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/campaign_file.hpp"
#include "repose/dem_adapter/campaign_upkeep.hpp"
#include "stop_signal.hpp"
#include "warning.hpp"

namespace repose::cli {
namespace {

using namespace dem_adapter;
namespace fs = std::filesystem;

struct CampaignCommandOptions {
  CommonOptions common;
  std::string directory;
  unsigned workers = 0;
  std::string engine;
  std::string table;
  std::vector<std::string> outcomes;
  bool outputs = false;
  bool unplanned = false;
};

nlohmann::json as_json(const CampaignStatus& s) {
  nlohmann::json json{{"wanted", s.wanted},
                      {"settled", s.settled},
                      {"failed", s.failed()},
                      {"under_way", s.under_way},
                      {"pending", s.pending},
                      {"running", s.running},
                      {"pending_because", s.pending_because},
                      {"queue_silence", s.queue_silence},
                      {"stopped", s.stopped},
                      {"recorded", s.recorded},
                      {"store", s.store.string()},
                      {"owner", s.owner},
                      {"wall_time_s", s.wall_time_s},
                      {"cpu_time_s", s.cpu_time_s},
                      {"peak_memory_bytes", s.peak_memory_bytes},
                      {"outcomes", nlohmann::json::object()}};
  for (const auto& [outcome, count] : s.counts) json["outcomes"][to_string(outcome)] = count;
  return json;
}

std::string status_text(const CampaignStatus& s) {
  constexpr std::size_t kColumns = 100;
  auto text = fmt::format("{} of {} runs have an outcome, {} failed; {} under way, {} stopped\n",
                          s.settled, s.wanted, s.failed(), s.under_way, s.stopped);
  if (s.pending + s.running > 0)
    text += fmt::format(
        "in the queue of SLURM: {} pending{}, {} running\n", s.pending,
        s.pending_because.empty() ? "" : fmt::format(" ({})", fmt::join(s.pending_because, ", ")),
        s.running);
  if (!s.queue_silence.empty())
    text += fmt::format("the queue of SLURM does not answer: {}\n", s.queue_silence);
  for (const auto& [outcome, count] : s.counts) {
    auto line = fmt::format("  {:<18}{:>7}", to_string(outcome), count);
    if (const auto it = s.examples.find(outcome); it != s.examples.end())
      line += "  e.g. " + it->second;
    text += (line.size() > kColumns ? line.substr(0, kColumns - 3) + "..." : line) + '\n';
  }
  if (s.settled > 0)
    text += fmt::format(
        "wall time {} in all, {} a run; CPU time {}; largest memory {:.3g} MB\n",
        duration_text(s.wall_time_s), duration_text(s.wall_time_s / static_cast<double>(s.settled)),
        duration_text(s.cpu_time_s), 1e-6 * static_cast<double>(s.peak_memory_bytes));
  text += fmt::format("store: {}, {} runs\n", s.store.string(), s.recorded);
  if (!s.owner.empty()) text += fmt::format("{} is working here\n", s.owner);
  return text;
}

void print(const CampaignCommandOptions& options, const nlohmann::json& json,
           const std::string& text) {
  fmt::print("{}", options.common.json ? json.dump(2) + "\n" : text);
}

/// The table of what there is now.
std::size_t write_table_of(const fs::path& directory, const CampaignFile& file,
                           const fs::path& output) {
  const auto plan = read_plan(directory);
  if (!plan)
    throw StorageError(fmt::format("'{}' has not been run yet; call repose campaign run first",
                                   directory.string()));
  return write_campaign_table(output, file, *plan, RunStore(plan->store, StoreAccess::read),
                              command_line());
}

void run_campaign(const CampaignCommandOptions& options) {
  const fs::path directory = options.directory;
  auto file = read_campaign(directory);
  if (options.workers > 0) file.compute.workers = options.workers;
  if (!options.engine.empty()) file.engine = parse_engine_choice(options.engine);
  const auto table = directory / "runs.h5";
  {
    const Campaign campaign(directory,
                            make_engine(file.scenario, file.engine,
                                        executor_of(file.compute, directory, print_warning)),
                            measure_of(file.scenario),
                            {.compute = file.compute,
                             .failures = file.failures,
                             .stop = &stop_requested(FirstInterrupt::lets_runs_end)});
    ProgressDisplay display("campaign", options.common.progress_style());
    campaign.run(file.wanted_runs(), display.callback());
    display.finish();
    write_campaign_table(table, file, *read_plan(directory), campaign.store(), command_line());
  }
  const auto status = campaign_status(directory);
  auto json = as_json(status);
  json["table"] = table.string();
  print(options, json, status_text(status) + fmt::format("table: {}\n", table.string()));
}

void print_status(const CampaignCommandOptions& options) {
  const auto status = campaign_status(options.directory);
  print(options, as_json(status), status_text(status));
}

void write_campaign_table_command(const CampaignCommandOptions& options) {
  const fs::path directory = options.directory;
  const fs::path output = options.table.empty() ? directory / "runs.h5" : fs::path(options.table);
  const auto rows = write_table_of(directory, read_campaign(directory), output);
  print(options, {{"rows", rows}, {"table", output.string()}},
        fmt::format("{} runs in {}\n", rows, output.string()));
}

void retry_failed_runs(const CampaignCommandOptions& options) {
  std::vector<Outcome> outcomes;
  for (const auto& name : options.outcomes) outcomes.push_back(outcome_named(name));
  if (outcomes.empty())
    std::copy_if(all_outcomes().begin(), all_outcomes().end(), std::back_inserter(outcomes),
                 is_failure);
  const auto keys = retry_runs(options.directory, outcomes);
  print(options, {{"runs", keys}},
        fmt::format("{} run{} will be done again by the next call of the campaign\n", keys.size(),
                    keys.size() == 1 ? "" : "s"));
}

void clean(const CampaignCommandOptions& options) {
  const auto cleaned = clean_campaign(
      options.directory,
      {.outputs = options.outputs ? CleanOutputs::remove : CleanOutputs::keep,
       .unplanned = options.unplanned ? CleanUnplanned::remove : CleanUnplanned::keep});
  print(options,
        {{"stopped", cleaned.stopped},
         {"outputs", cleaned.outputs},
         {"unplanned", cleaned.unplanned},
         {"beginnings", cleaned.beginnings},
         {"bytes", cleaned.bytes}},
        fmt::format("removed {} stopped runs, {} outputs, {} runs of no plan and {} shared "
                    "beginnings: {:.3g} MB\n",
                    cleaned.stopped, cleaned.outputs, cleaned.unplanned, cleaned.beginnings,
                    1e-6 * static_cast<double>(cleaned.bytes)));
}

struct TaskOptions {
  std::string array;
  int task = 0;
};

/// SLURM tells a job to end by SIGTERM.
void run_task(const TaskOptions& options) {
  const auto& stop = stop_requested(FirstInterrupt::ends_runs);
  run_slurm_task(options.array, options.task, [&] { return stop != Stop::no; });
}

void add_task(CLI::App& group) {
  auto o = std::make_shared<TaskOptions>();
  auto* task = group.add_subcommand(
      "task", "What a job of SLURM calls on its node: one run of a job array (not for users)");
  task->add_option("ARRAY", o->array, "folder of the job array, DIR/slurm/NAME")->required();
  task->add_option("TASK", o->task, "its number in the array")
      ->required()
      ->check(CLI::NonNegativeNumber);
  task->footer(
      "Example: repose campaign task friction/slurm/repose-1f00 3\n"
      "Runs the program that the run's submitted.json names, with its time limit and log, passes "
      "a\n"
      "SIGTERM on so that it can write a checkpoint, and writes ARRAY/TASK.end.\n"
      "docs/how-to/cluster.md tells how campaigns use it.");
  task->callback([o] { run_task(*o); });
}

using Options = std::shared_ptr<CampaignCommandOptions>;

CLI::App* add_kind(CLI::App& group, const std::string& name, const std::string& description,
                   const std::string& example, const Options& o,
                   void (*action)(const CampaignCommandOptions&)) {
  auto* command =
      add_command(group, name, description, "repose campaign " + name + " " + example, o->common);
  command->add_option("DIR", o->directory, "folder of the campaign")->required();
  command->callback([o, action] { action(*o); });
  return command;
}

}  // namespace

void add_campaign(CLI::App& app) {
  auto* group = app.add_subcommand(
      "campaign", "Many runs of a scenario: begin, go on, look, do again, clean up");
  group->require_subcommand(1);
  auto o = std::make_shared<CampaignCommandOptions>();
  auto* run = add_kind(*group, "run",
                       "Does the runs that DIR/campaign.toml asks for and that are not there yet",
                       "friction", o, run_campaign);
  run->footer(
      "Example: repose campaign run friction\n"
      "with friction/campaign.toml:\n"
      "  scenario = { scenario = \"drawdown\", preset = \"quick\" }\n"
      "  points = \"points.h5\"      # e.g. of repose design lhs; one column a parameter\n"
      "  repetitions = 2\n"
      "Ctrl-C lets the runs under way end, a second one stops them with a checkpoint; the same\n"
      "command goes on. docs/how-to/campaign.md has all keys.");
  run->add_option("--workers", o->workers, "runs at once; 0: as many as cores and memory hold")
      ->check(CLI::Range(0, 4096));
  run->add_option(
      "--engine", o->engine,
      "in place of [engine]: its name, or the path of a program that is\ncalled as repose-dem is");
  add_kind(*group, "status", "How far a campaign or a calibration is; changes nothing", "friction",
           o, print_status);
  auto* table = add_kind(*group, "table", "Writes one table of all runs that are there",
                         "friction -o friction.csv", o, write_campaign_table_command);
  table->add_option("-o,--output", o->table, "table to write (.h5 or .csv); default DIR/runs.h5");
  auto* retry = add_kind(*group, "retry", "Marks failed runs to be done again",
                         "friction --outcome time-limit", o, retry_failed_runs);
  retry->add_option("--outcome", o->outcomes,
                    "only runs that ended so, e.g. crash; may be repeated; default: all failures");
  auto* cleaning = add_kind(*group, "clean", "Removes what stopped runs left behind",
                            "friction --outputs", o, clean);
  cleaning->add_flag("--outputs", o->outputs,
                     "also the engine's output of finished runs; their KPIs stay");
  cleaning->add_flag("--unplanned", o->unplanned, "also runs that the plan does not name");
  add_task(*group);
}

}  // namespace repose::cli
