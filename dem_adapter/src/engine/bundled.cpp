#include <fmt/format.h>

#include "programs.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/engine.hpp"

namespace repose::dem_adapter {
namespace {

/// The failures of repose-dem that have a name, by what only their messages contain.
Outcome outcome_of(const std::string& message) {
  struct Sign {
    const char* words;
    Outcome outcome;
  };
  static constexpr Sign kSigns[] = {{"left the domain", Outcome::particles_lost},
                                    {"has the position", Outcome::non_finite},
                                    {"raise youngs_modulus_pa", Outcome::unphysical},
                                    {"lower the time step", Outcome::unphysical}};
  for (const auto& sign : kSigns)
    if (message.find(sign.words) != std::string::npos) return sign.outcome;
  return Outcome::engine_failed;
}

/// A code that says nothing about this run but that no run can succeed: bad input, a full disk. The
/// study must stop then, not record failures.
void throw_if_not_the_run(int code, const std::string& message,
                          const std::filesystem::path& program) {
  const auto text = fmt::format("{}: {}", program.filename().string(), message);
  if (code == static_cast<int>(ErrorKind::input)) throw InputError(text);
  if (code == static_cast<int>(ErrorKind::storage)) throw StorageError(text);
  if (code == static_cast<int>(ErrorKind::internal) || code == static_cast<int>(ErrorKind::usage))
    throw Error(ErrorKind::internal, text);
}

}  // namespace

BundledEngine::BundledEngine(std::filesystem::path program, double grace_s, Executor executor)
    : program_(program.empty() ? find_program("repose-dem", "build or install it")
                               : std::move(program)),
      grace_s_(grace_s),
      executor_(std::move(executor)) {
  if (!(grace_s_ >= 0.0))
    throw InputError(fmt::format(
        "the grace of an engine is {} s; give 0 or more, enough for a checkpoint", grace_s_));
  check_executable(program_);
  name_ = fmt::format("bundled {} build {}", version(), content_of(program_));
}

std::string BundledEngine::name() const {
  return name_;
}

EngineExit BundledEngine::run(const EngineJob& job) const {
  Command command{.words = {program_.string(), (job.directory / "case.toml").string(), "-o",
                            (job.directory / "output").string()},
                  .processes = job.ranks,
                  .time_limit_s = job.time_limit_s,
                  .grace_s = grace_s_,
                  .cancelled = job.cancelled};
  if (job.streams == EngineStreams::to_log) {
    command.log = job.directory / "engine.log";
    command.words.emplace_back("--quiet");
  }
  if (job.ranks > 1) {
    command.words.emplace_back("--ranks");
    command.words.push_back(std::to_string(job.ranks));
  }
  if (!job.until.empty()) {
    command.words.emplace_back("--until");
    command.words.push_back(job.until);
  }
  const auto said_before = size_of(command.log);
  const auto end = executor_.run(command);
  auto exit = exit_of(end, command, said_before);
  if (exit.status == EngineStatus::failed && end.signal == 0) {
    throw_if_not_the_run(end.exit_code, exit.message, program_);
    exit.failure = outcome_of(exit.message);
  }
  return exit;
}

}  // namespace repose::dem_adapter
