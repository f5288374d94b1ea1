#include "repose/dem_adapter/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "directory_lock.hpp"
#include "outcome_json.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/base/text.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/dem_adapter/submission.hpp"
#include "repose/scene/run_output.hpp"
#include "run_folder.hpp"
#include "shared_beginnings.hpp"
#include "tally.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::uint64_t kRetryStream = 400;
constexpr int kKillsBelieved = 3;  // killed by others so often in a row, it is about the run

/// What earlier parts of a run that goes on have used.
Resources earlier_parts(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(parts_file(folder))) return {.parts = 0};
  try {
    return parse_resources(read_file(parts_file(folder)));
  } catch (const nlohmann::json::exception&) {
    return {.parts = 0};
  }
}

}  // namespace

Measure measure_of(const Scenario& scenario) {
  auto name = fmt::format("{} {}: {}", scenario.name(), version(), listed(scenario.kpi_names()));
  if (const auto definition = scenario.kpi_definition(); !definition.empty())
    name += fmt::format(" by {:016x}", content_hash(definition));
  return {std::move(name),
          [scenario](const std::filesystem::path& output) { return scenario.measure(output); }};
}

Campaign::Campaign(std::filesystem::path directory, Engine engine, Measure measure,
                   CampaignOptions options)
    : directory_(std::move(directory)),
      engine_(std::move(engine)),
      measure_(std::move(measure)),
      options_(std::move(options)),
      workers_(runs_at_once(options_.compute)) {
  const auto& store = options_.compute.store;
  lock_ = std::make_unique<DirectoryLock>(directory_);
  store_ = std::make_unique<RunStore>(store.empty() ? directory_ : store, StoreAccess::write);
  if (!std::filesystem::equivalent(store_->directory(), directory_))
    note_user(store_->directory(), directory_);
  plan_ = {.store = std::filesystem::absolute(store_->directory()),
           .retry_on = options_.failures.retry_on,
           .runs = {}};
}

Campaign::~Campaign() = default;

bool Campaign::wants_retry(const RunOutcome& outcome) const {
  const auto& on = options_.failures.retry_on;
  return std::find(on.begin(), on.end(), outcome.measurement.outcome) != on.end();
}

Seeds read_seeds(const TomlTable& root) {
  return root.choice_or("seeds", "own", {"own", "common"}) == "common" ? Seeds::common : Seeds::own;
}

std::uint64_t attempt_seed(std::uint64_t seed, int attempt) {
  return attempt == 0
             ? seed
             : derive_seed(derive_seed(seed, kRetryStream), static_cast<std::uint64_t>(attempt));
}

Campaign::Attempt Campaign::attempt_of(const WantedRuns& wanted, std::size_t run,
                                       int attempt) const {
  auto input = wanted.make_input(run, attempt);
  auto key = run_key(engine_.name(), input.text);
  return {.input = std::move(input), .key = std::move(key)};
}

std::optional<RunOutcome> Campaign::standing(const Attempt& attempt,
                                             const std::optional<RunOutcome>& recorded) const {
  if (!recorded) return std::nullopt;
  const auto folder = store_->folder(attempt.key);
  if (read_file(folder / "case.toml") != attempt.input.text)
    throw StorageError(fmt::format(
        "'{}' belongs to another case than its name says; move that folder away", folder.string()));
  const double limit = options_.compute.time_limit_s;
  const bool more_time = limit == 0.0 || limit > recorded->exceeded_limit_s;
  if (recorded->exceeded_limit_s > 0.0 && more_time) return std::nullopt;
  const bool is_as_we_measure =
      recorded->measured_by.empty() || recorded->measured_by == measure_.name;
  // Why it could not be read may have passed.
  const bool is_readable = recorded->measurement.outcome != Outcome::output_unreadable;
  return is_as_we_measure && is_readable ? recorded : std::nullopt;
}

std::optional<RunOutcome> Campaign::settled_by(const Attempt& attempt,
                                               const std::optional<RunOutcome>& recorded) const {
  if (auto outcome = standing(attempt, recorded)) return outcome;
  const auto output = store_->folder(attempt.key) / "output";
  const bool is_finished = recorded && !recorded->measured_by.empty();
  if (!is_finished || !std::filesystem::is_directory(output)) return std::nullopt;
  return measured_anew(*recorded);
}

/// Other KPIs were wanted when it was measured, or it was measured in another way, or it could not
/// be read; if it cannot be now, its record stays.
RunOutcome Campaign::measured_anew(RunOutcome outcome) const {
  outcome.measurement = measured(store_->folder(outcome.key) / "output");
  outcome.measured_by = measure_.name;
  if (outcome.measurement.outcome != Outcome::output_unreadable) store_->record(outcome);
  return outcome;
}

Measurement Campaign::measured(const std::filesystem::path& output) const {
  Measurement m;
  try {
    m = measure_.of(output);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::internal) throw;
    m.fail(Outcome::output_unreadable,
           fmt::format("its output cannot be measured: {}", error.what()));
  }
  m.drop_undefined_kpis();
  return m;
}

/// Of the limit, which is for all parts of a run together.
double Campaign::remaining_time_s(const Resources& used) const {
  constexpr double kLeast = 1e-3;  // 0 would be no limit
  const double limit = options_.compute.time_limit_s;
  return limit == 0.0 ? 0.0 : std::max(kLeast, limit - used.wall_time_s);
}

EngineExit Campaign::run_engine(const std::filesystem::path& folder,
                                const std::function<bool()>& cancelled) const {
  auto used = earlier_parts(folder);
  for (int kills = 0;;) {
    auto exit = engine_.run({.directory = folder,
                             .ranks = options_.compute.ranks,
                             .time_limit_s = remaining_time_s(used),
                             .cancelled = cancelled});
    used += exit.resources;
    exit.resources = used;
    if (exit.status == EngineStatus::finished || exit.status == EngineStatus::failed) return exit;
    write_file_atomically(parts_file(folder), resources_text(used));
    forget_submission(folder);
    if (exit.status == EngineStatus::cancelled || cancelled()) throw Interrupted();
    if (exit.status == EngineStatus::timed_out || ++kills == kKillsBelieved) return exit;
  }
}

RunOutcome Campaign::run_one(const Attempt& attempt, const std::atomic<bool>& given_up) const {
  const auto cancelled = [&] { return given_up || stop() == Stop::now; };
  const auto begins_no_more = [&] { return given_up || stop() != Stop::no; };
  if (begins_no_more()) throw Interrupted();
  const auto folder = store_->folder(attempt.key);
  const auto claim = RunClaim::take(folder, begins_no_more);
  if (!claim || begins_no_more()) throw Interrupted();
  const auto recorded = store_->find_in_folder(attempt.key);
  if (auto done = settled_by(attempt, recorded)) return *done;  // somebody else was faster
  if (recorded) store_->forget(attempt.key);                    // done again, with more time
  EngineExit exit{.status = EngineStatus::finished};
  if (const auto used = finished_before(folder)) {
    exit.resources = *used;
  } else {
    if (!submission_of(folder)) {  // else it is at work there, or was, and is waited for
      prepare_folder(folder, attempt.input.text);
      if (beginnings_) beginnings_->hand_to(folder, attempt.input.text);
    }
    exit = run_engine(folder, cancelled);
    if (exit.status == EngineStatus::finished)
      write_file_atomically(finished_file(folder), resources_text(exit.resources));
  }
  const auto outcome = outcome_of(attempt, exit);
  store_->record(outcome);
  std::error_code ignored;
  std::filesystem::remove(finished_file(folder), ignored);
  forget_submission(folder);
  return outcome;
}

RunOutcome Campaign::outcome_of(const Attempt& attempt, const EngineExit& exit) const {
  RunOutcome outcome{.key = attempt.key,
                     .seed = attempt.input.seed,
                     .engine = engine_.name(),
                     .resources = exit.resources};
  const double limit = options_.compute.time_limit_s;
  switch (exit.status) {
    case EngineStatus::finished:
      outcome.measurement = measured(store_->folder(attempt.key) / "output");
      outcome.measured_by = measure_.name;
      break;
    case EngineStatus::timed_out:
      outcome.exceeded_limit_s = limit;
      outcome.measurement.fail(Outcome::time_limit, fmt::format("it exceeded the time limit of {}",
                                                                duration_text(limit)));
      break;
    case EngineStatus::killed:
      outcome.measurement.fail(Outcome::killed, exit.message);
      break;
    default:
      outcome.measurement.fail(exit.failure, exit.message);
  }
  return outcome;
}

RunOutcome Campaign::brought_about(const WantedRuns& wanted, std::size_t run,
                                   const std::atomic<bool>& given_up) const {
  for (int i = 0;; ++i) {
    const auto attempt = attempt_of(wanted, run, i);
    auto outcome = standing(attempt, store_->find(attempt.key));
    if (!outcome) outcome = run_one(attempt, given_up);
    if (i == options_.failures.retries || !wants_retry(*outcome)) return *outcome;
  }
}

void Campaign::run(const WantedRuns& wanted, const ProgressCallback& progress) const {
  Tally tally(wanted.count, options_.failures.stop_above, progress);
  // What is finished is read first, so that the rate shown is that of new runs.
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < wanted.count; ++i) {
    auto& keys = plan_.runs.emplace_back();
    std::map<std::string, RunOutcome> known;
    for (int k = 0; k <= options_.failures.retries; ++k) {
      const auto attempt = attempt_of(wanted, i, k);
      keys.push_back(attempt.key);
      if (auto outcome = standing(attempt, store_->find(attempt.key)))
        known.emplace(attempt.key, std::move(*outcome));
    }
    const auto outcome = settled(keys, plan_.retry_on, [&](const std::string& key) {
      const auto it = known.find(key);
      return it == known.end() ? std::nullopt : std::optional(it->second);
    });
    if (outcome)
      tally.found(*outcome);
    else
      open.push_back(i);
  }
  write_plan(directory_, plan_);
  tally.begin();
  make_beginnings(wanted, open);
  do_all(open.size(), [&](std::size_t i, const std::atomic<bool>& given_up) {
    tally.finished(brought_about(wanted, open[i], given_up));
  });
}

void Campaign::do_all(
    std::size_t count,
    const std::function<void(std::size_t, const std::atomic<bool>& given_up)>& task) const {
  std::atomic<bool> given_up{false};
  std::mutex mutex;
  std::exception_ptr reason;  // of giving up: an error that concerns every run
  parallel_for(count, workers_, [&](std::size_t i) {
    try {
      task(i, given_up);
    } catch (const Interrupted&) {
      if (!given_up) throw;
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!reason) reason = std::current_exception();
      given_up = true;
    }
  });
  if (reason) std::rethrow_exception(reason);
}

void Campaign::make_beginnings(const WantedRuns& wanted,
                               const std::vector<std::size_t>& open) const {
  if (options_.compute.beginnings == Beginnings::own) return;
  beginnings_ = std::make_unique<SharedBeginnings>(
      store_->directory() / "beginnings", engine_, open.size(),
      [&](std::size_t i) { return wanted.make_input(open[i], 0).text; });
  for (const auto& [first, last] : beginnings_->generations())
    do_all(last - first, [&, first = first](std::size_t i, const std::atomic<bool>& given_up) {
      if (stop() != Stop::no) throw Interrupted();
      beginnings_->make(first + i, options_.compute,
                        [&] { return given_up || stop() == Stop::now; });
    });
}

std::vector<RunOutcome> Campaign::outcomes(const WantedRuns& wanted,
                                           const ProgressCallback& progress) const {
  run(wanted, progress);
  std::vector<RunOutcome> outcomes;
  const auto find = [this](const std::string& key) { return store_->find(key); };
  for (std::size_t i = plan_.runs.size() - wanted.count; i < plan_.runs.size(); ++i) {
    auto outcome = settled(plan_.runs[i], plan_.retry_on, find);
    if (!outcome)
      throw StorageError(fmt::format("the folder of run {} in '{}' was removed meanwhile",
                                     plan_.runs[i].front(), store_->directory().string()));
    outcomes.push_back(std::move(*outcome));
  }
  return outcomes;
}

double mean_wall_time_s(const std::filesystem::path& directory) {
  if (!std::filesystem::is_directory(directory / "runs")) return 0.0;
  const RunStore store(directory, StoreAccess::read);
  double sum = 0.0;
  int runs = 0;
  for (const auto& key : store.keys())
    if (const auto outcome = store.find(key); outcome && !outcome->failed()) {
      sum += outcome->resources.wall_time_s;
      ++runs;
    }
  return runs > 0 ? sum / runs : 0.0;
}

}  // namespace repose::dem_adapter
