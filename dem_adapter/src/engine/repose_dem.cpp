#include "repose_dem.hpp"

#include <fmt/format.h>

#include "programs.hpp"
#include "repose/base/error.hpp"

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
void throw_if_not_the_run(int code, const std::string& message, const std::string& program) {
  const auto text =
      fmt::format("{}: {}", std::filesystem::path(program).filename().string(), message);
  if (code == static_cast<int>(ErrorKind::input)) throw InputError(text);
  if (code == static_cast<int>(ErrorKind::storage)) throw StorageError(text);
  if (code == static_cast<int>(ErrorKind::internal) || code == static_cast<int>(ErrorKind::usage))
    throw Error(ErrorKind::internal, text);
}

}  // namespace

EngineExit exit_of_repose_dem(const CommandEnd& end, const Command& command,
                              std::size_t said_before) {
  auto exit = exit_of(end, command, said_before);
  if (exit.status == EngineStatus::failed && exit.failure != Outcome::crash) {
    throw_if_not_the_run(end.exit_code, exit.message, command.words.front());
    exit.failure = outcome_of(exit.message);
  }
  return exit;
}

}  // namespace repose::dem_adapter
