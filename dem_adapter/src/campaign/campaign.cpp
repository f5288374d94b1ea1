#include "repose/dem_adapter/campaign.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

#include "outcome_file.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

Campaign::Campaign(std::filesystem::path directory, Engine engine, Measure measure,
                   CampaignOptions options)
    : directory_(std::move(directory)),
      engine_(std::move(engine)),
      measure_(std::move(measure)),
      options_(options) {
  if (options_.workers == 0) options_.workers = std::max(1U, std::thread::hardware_concurrency());
  make_directory(directory_ / "runs");
  const auto lock_file = directory_ / ".lock";
  lock_ = ::open(lock_file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0)
    throw StorageError(
        fmt::format("cannot write in '{}': {}", directory_.string(), std::strerror(errno)));
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    const int code = errno;
    ::close(lock_);
    throw StorageError(
        code == EWOULDBLOCK
            ? fmt::format("another process is working in '{}'; wait for it or choose another "
                          "directory",
                          directory_.string())
            : fmt::format("cannot lock '{}': {}", lock_file.string(), std::strerror(code)));
  }
}

Campaign::~Campaign() {
  ::close(lock_);
}

std::string Campaign::key_of(const std::string& case_text) const {
  return fmt::format("{:016x}", content_hash(engine_.name() + '\n' + case_text));
}

std::optional<RunOutcome> Campaign::recorded(const std::string& key,
                                             const std::string& case_text) const {
  const auto folder = directory_ / "runs" / key;
  auto outcome = read_outcome(folder / "outcome.json");
  if (!outcome) return std::nullopt;
  if (read_file(folder / "case.toml") != case_text)
    throw StorageError(fmt::format(
        "'{}' belongs to another case than its name says; move that folder away", folder.string()));
  const bool more_time =
      options_.time_limit_s == 0.0 || options_.time_limit_s > outcome->exceeded_limit_s;
  if (outcome->exceeded_limit_s > 0.0 && more_time) return std::nullopt;
  return outcome;
}

RunOutcome Campaign::run_one(const std::string& key, const std::string& case_text,
                             const std::atomic<bool>& given_up) const {
  const auto cancelled = [&] {
    return given_up || (options_.cancelled != nullptr && *options_.cancelled);
  };
  if (cancelled()) throw Interrupted();
  const auto folder = directory_ / "runs" / key;
  std::error_code code;
  if (!std::filesystem::exists(scene::checkpoint_file(folder / "output")))
    std::filesystem::remove_all(folder / "output", code);  // of a run that cannot go on
  if (code)
    throw StorageError(
        fmt::format("cannot remove '{}': {}", (folder / "output").string(), code.message()));
  make_directory(folder);
  write_file_atomically(folder / "case.toml", case_text);
  const auto exit = engine_.run(
      {.directory = folder, .time_limit_s = options_.time_limit_s, .cancelled = cancelled});
  if (exit.status == EngineStatus::cancelled) throw Interrupted();
  RunOutcome outcome{.key = key, .measurement = {}, .wall_time_s = exit.wall_time_s};
  if (exit.status == EngineStatus::timed_out) outcome.exceeded_limit_s = options_.time_limit_s;
  if (exit.status == EngineStatus::finished)
    outcome.measurement = measured(folder / "output");
  else
    outcome.measurement.failure = exit.message;
  write_outcome(folder / "outcome.json", outcome, engine_.name());
  return outcome;
}

Measurement Campaign::measured(const std::filesystem::path& output) const {
  Measurement m;
  try {
    m = measure_(output);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::storage || error.kind() == ErrorKind::internal) throw;
    m.failure = fmt::format("its output cannot be measured: {}", error.what());
  }
  for (const auto& [name, value] : m.kpis)
    if (!std::isfinite(value) && m.failure.empty())
      m.failure = fmt::format("{} is {}: the scenario gave no finite value", name, value);
  if (!m.failure.empty()) m.kpis.clear();
  std::erase_if(m.details, [](const auto& detail) { return !std::isfinite(detail.second); });
  return m;
}

std::vector<RunOutcome> Campaign::run(const std::vector<scene::Case>& cases,
                                      const ProgressCallback& progress) const {
  std::vector<std::string> keys;
  std::map<std::string, std::string> texts;  // by key: equal cases are one run
  std::vector<std::string> order;
  for (const auto& c : cases) {
    auto text = scene::case_text(c);
    keys.push_back(key_of(text));
    const auto [it, is_new] = texts.emplace(keys.back(), text);
    REPOSE_ASSERT(it->second == text, "two cases share the key " + keys.back());
    if (is_new) order.push_back(keys.back());
  }
  std::mutex mutex;
  std::map<std::string, RunOutcome> outcomes;
  std::size_t failed = 0;
  // What is finished is read first, so that the rate shown is that of new runs.
  std::vector<std::string> open;
  for (const auto& key : order) {
    if (auto outcome = recorded(key, texts.at(key))) {
      failed += outcome->usable() ? 0 : 1;
      outcomes.emplace(key, std::move(*outcome));
    } else {
      open.push_back(key);
    }
  }
  const auto report = [&] {
    if (!progress) return;
    const auto note = fmt::format("{} of {} runs{}", outcomes.size(), order.size(),
                                  failed > 0 ? fmt::format(", {} failed", failed) : "");
    progress(static_cast<double>(outcomes.size()), static_cast<double>(order.size()), note);
  };
  report();
  std::atomic<bool> given_up{false};
  std::exception_ptr reason;  // of giving up: an error that concerns every run
  parallel_for(open.size(), options_.workers, [&](std::size_t i) {
    RunOutcome outcome;
    try {
      outcome = run_one(open[i], texts.at(open[i]), given_up);
    } catch (const Interrupted&) {
      if (!given_up) throw;
      return;
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!reason) reason = std::current_exception();
      given_up = true;
      return;
    }
    const std::lock_guard lock(mutex);
    failed += outcome.usable() ? 0 : 1;
    outcomes.emplace(open[i], std::move(outcome));
    report();
  });
  if (reason) std::rethrow_exception(reason);
  std::vector<RunOutcome> result;
  for (const auto& key : keys) result.push_back(outcomes.at(key));
  return result;
}

double mean_wall_time_s(const std::filesystem::path& directory) {
  if (!std::filesystem::is_directory(directory / "runs")) return 0.0;
  double sum = 0.0;
  int runs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "runs"))
    if (const auto outcome = read_outcome(entry.path() / "outcome.json");
        outcome && outcome->usable()) {
      sum += outcome->wall_time_s;
      ++runs;
    }
  return runs > 0 ? sum / runs : 0.0;
}

}  // namespace repose::dem_adapter
