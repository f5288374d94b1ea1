#include <fmt/format.h>

#include "programs.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose_dem.hpp"

namespace repose::dem_adapter {

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
                  .cancelled = job.cancelled,
                  .home = job.directory};
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
  return exit_of_repose_dem(executor_.run(command), command, said_before);
}

}  // namespace repose::dem_adapter
