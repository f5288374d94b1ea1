// What engines that are programs have in common.
#pragma once

#include <filesystem>
#include <string>

#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/executor.hpp"

namespace repose::dem_adapter {

/// A program beside the running one, else on PATH. Throws StorageError that ends with `remedy`.
std::filesystem::path find_program(const std::string& name, const std::string& remedy);
/// Throws StorageError if the program cannot be run.
void check_executable(const std::filesystem::path& program);
/// Names a build: two builds may differ in physics under the same version.
std::string content_of(const std::filesystem::path& program);

std::size_t size_of(const std::filesystem::path& file);  ///< 0 if there is none

/// Whether somebody ended the program, or one of its processes: the machine shutting down, the
/// kernel out of memory, a user.
bool was_killed(const CommandEnd& end);

/// What an end says whatever the engine: finished (code 0), timed out, cancelled, killed by others,
/// crashed; else failed, with the last words in the log from byte `said_before` as its message.
EngineExit exit_of(const CommandEnd& end, const Command& command, std::size_t said_before);

}  // namespace repose::dem_adapter
