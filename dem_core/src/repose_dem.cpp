// The program repose-dem: runs a case file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "parallel/communicator.hpp"
#include "parallel/launcher.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem/run_case.hpp"
#include "repose/scene/case_keys.hpp"

namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t stop_signal = 0;
volatile std::sig_atomic_t checkpoint_asked = 0;
void note_stop(int number) {
  stop_signal = number;
}
void note_checkpoint(int) {
  checkpoint_asked = 1;
}

repose::dem::Request request() {
  if (stop_signal != 0) return repose::dem::Request::stop;
  if (checkpoint_asked == 0) return repose::dem::Request::none;
  checkpoint_asked = 0;
  return repose::dem::Request::write_checkpoint;
}

std::string footer() {
  return "Example:\n"
         "  repose-dem tests/data/quick_drawdown.toml -o run\n"
         "\n"
         "Keys of the case file (TOML, SI): key, unit, (default), meaning\n" +
         repose::scene::case_keys_text() +
         "\n"
         "A run that was stopped, by Ctrl-C, SIGTERM or a crash, goes on by the same command from\n"
         "its last checkpoint, and ends with the same bits as if it had not been stopped. Ctrl-C "
         "and\n"
         "SIGTERM write a checkpoint first; SIGUSR1 writes one and goes on.\n"
         "\n"
         "--ranks N simulates with N processes, by mpirun; a launcher of MPI may also start\n"
         "repose-dem itself. The result has the same bits on any number of them, also where a run\n"
         "goes on with another number than it began with.\n"
         "\n"
         "Exit codes: 0 done, 1 internal error, 2 usage, 3 bad input, 5 simulation failure, 6 "
         "file\n"
         "or storage, 130 stopped by Ctrl-C and 143 by SIGTERM, both after a checkpoint.";
}

bool is_root() {
  return repose::dem::Communicator::of_launcher().is_root();
}

struct Options {
  std::string case_file;
  std::string output;
  std::optional<std::uint64_t> seed;
  int ranks = 1;
  std::string balance = "by-cost";
  std::string until;
  bool from_start = false;
  bool place = false;
  bool quiet = false;
  bool json = false;
};

bool is_file_name(const fs::path& output) {
  return output.extension() == ".h5";
}

void print_json(const repose::scene::RunSummary& s, const std::string& output) {
  nlohmann::ordered_json json;
  json["output"] = output;
  json["spheres"] = s.spheres;
  json["bodies"] = {{"inserted", s.bodies.inserted},     {"removed", s.bodies.removed},
                    {"alive", s.bodies.alive},           {"inserted_kg", s.bodies.inserted_kg},
                    {"removed_kg", s.bodies.removed_kg}, {"alive_kg", s.bodies.alive_kg}};
  json["time_step_s"] = s.time_step_s;
  json["steps"] = s.steps;
  json["wall_time_s"] = s.wall_time_s;
  json["largest_overlap_ratio"] = s.largest_overlap_ratio;
  json["state_hash"] = s.state_hash;
  json["seed"] = s.seed;
  json["stages"] = nlohmann::ordered_json::array();
  for (const repose::scene::StageEnd& stage : s.stages)
    json["stages"].push_back(
        {{"name", stage.name}, {"end_time_s", stage.time_s}, {"reason", stage.reason}});
  std::puts(json.dump(2).c_str());
}

void print_text(const repose::scene::RunSummary& s, const std::string& output) {
  fmt::print(
      "{} bodies ({} spheres), {:.6g} kg, {} steps of {:.4g} s in {:.3g} s; largest overlap "
      "{:.3g}; state {}\n",
      s.bodies.alive, s.spheres, s.bodies.alive_kg, s.steps, s.time_step_s, s.wall_time_s,
      s.largest_overlap_ratio, s.state_hash);
  if (s.bodies.removed > 0)
    fmt::print("{} bodies, {:.6g} kg were removed\n", s.bodies.removed, s.bodies.removed_kg);
  for (const repose::scene::StageEnd& stage : s.stages)
    fmt::print("stage {}: {:.4g} s, {}\n", stage.name, stage.time_s, stage.reason);
  const fs::path folder = output;
  if (is_file_name(output))
    fmt::print("{}\n", output);
  else if (fs::exists(folder / "run.h5"))
    fmt::print("{}\n", (folder / "run.h5").string());
  else
    fmt::print("it waits in {} and goes on without --until\n", output);
}

void print_summary(const repose::scene::RunSummary& summary, const Options& options) {
  if (options.json)
    print_json(summary, options.output);
  else
    print_text(summary, options.output);
}

void run(const Options& options) {
  const int started = repose::dem::Communicator::of_launcher().size();
  if (options.ranks > 1 && options.ranks != started)
    throw repose::UsageError(
        fmt::format("--ranks {}, but the launcher of MPI started {}; leave --ranks out",
                    options.ranks, started));
  repose::scene::Case scene = repose::scene::read_case(options.case_file);
  if (options.seed) scene.seed = *options.seed;
  if (options.place) {
    if (started > 1) throw repose::UsageError("--place is done by one process; leave --ranks out");
    if (is_file_name(options.output))
      throw repose::UsageError("--place writes a folder; name one that does not end with .h5");
    print_summary(repose::dem::place_particles(scene, options.output), options);
    return;
  }
  repose::ProgressDisplay display("repose-dem", options.quiet || !is_root()
                                                    ? repose::ProgressStyle::quiet
                                                    : repose::ProgressStyle::automatic);
  const auto start =
      options.from_start ? repose::dem::Start::anew : repose::dem::Start::where_stopped;
  const auto warn = [&](std::string_view text) {
    display.finish();
    fmt::print(stderr, "repose-dem: warning: {}\n", text);
  };
  const auto run_into =
      is_file_name(options.output) ? repose::dem::run_case_into_file : repose::dem::run_case;
  const repose::scene::RunSummary summary =
      run_into(scene, options.output,
               {.progress = display.callback(),
                .request = request,
                .warn = warn,
                .start = start,
                .until = options.until,
                .balance = options.balance == "never" ? repose::dem::Balance::never
                                                      : repose::dem::Balance::by_cost});
  display.finish();
  if (is_root()) print_summary(summary, options);
}

struct Failure {
  std::string message;
  int exit_code;
};

/// Runs the case; what went wrong, if anything did.
std::optional<Failure> attempt(const Options& options) {
  try {
    run(options);
    return std::nullopt;
  } catch (const repose::dem::RunStopped& stopped) {
    const bool by_ctrl_c = stop_signal == SIGINT;
    return Failure{stopped.what(), 128 + (by_ctrl_c ? SIGINT : SIGTERM)};  // as a shell reports it
  } catch (const repose::Error& error) {
    return Failure{error.what(), error.exit_code()};
  } catch (const std::exception& error) {
    return Failure{std::string("internal error: ") + error.what(),
                   static_cast<int>(repose::ErrorKind::internal)};
  }
}

/// What fails on all ranks is said once; what fails on one ends all.
int report(const Failure& failure, const repose::dem::ParallelSession* session) {
  const bool all_know = session == nullptr || session->all_failed();
  if (!all_know) {
    fmt::print(stderr, "repose-dem: rank {}: {}\n", repose::dem::Communicator::of_launcher().rank(),
               failure.message);
    session->abort(failure.exit_code);
  }
  if (is_root()) fmt::print(stderr, "repose-dem: {}\n", failure.message);
  return failure.exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, note_stop);
  std::signal(SIGTERM, note_stop);
  std::signal(SIGUSR1, note_checkpoint);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like a full disk
  std::optional<repose::dem::ParallelSession> session;
  if (repose::dem::was_launched_in_parallel()) {
    std::signal(repose::dem::kStopRanks, note_stop);
    session.emplace(&argc, &argv);
  }
  CLI::App app(
      "Runs a discrete element simulation: spheres and clumps between walls, from a case file.",
      "repose-dem");
  app.footer(footer());
  Options options;
  app.add_option("case", options.case_file, "Case file")->required();
  app.add_option("-o,--output", options.output, "Folder of the run, or RUN.h5 for one file")
      ->required();
  app.add_option("--seed", options.seed, "Replaces run.seed of the case");
  app.add_option("-n,--ranks", options.ranks, "Processes that simulate together")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--balance", options.balance,
                 "When the domain is cut anew; changes no bit of the result")
      ->check(CLI::IsMember({"by-cost", "never"}))
      ->capture_default_str();
  app.add_option("--until", options.until,
                 "Wait at the end of this stage; without it the run goes on, also with a case\n"
                 "of which only later stages differ");
  app.add_flag("--from-start", options.from_start,
               "Begin anew where the folder holds a checkpoint");
  app.add_flag("--place", options.place,
               "Only places the particles: OUTPUT/run.h5:/snapshots/000001 has them");
  app.add_flag("--quiet", options.quiet, "No progress");
  app.add_flag("--json", options.json, "Summary as JSON on stdout");
  app.set_version_flag("--version", repose::version());
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(repose::ErrorKind::usage);
  }
  if (options.ranks > 1 && !session) {
    try {
      return repose::dem::launch_ranks(options.ranks, argc, argv);
    } catch (const repose::Error& error) {
      fmt::print(stderr, "repose-dem: {}\n", error.what());
      return error.exit_code();
    }
  }
  const std::optional<Failure> failure = attempt(options);
  if (!failure) return 0;
  return report(*failure, session ? &*session : nullptr);
}
