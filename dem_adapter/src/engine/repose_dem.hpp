// What the end of the program repose-dem says.
#pragma once

#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/executor.hpp"

namespace repose::dem_adapter {

/// exit_of() with the names of its failures. Throws the Error of the program where no run could
/// succeed: bad input, a full disk.
EngineExit exit_of_repose_dem(const CommandEnd& end, const Command& command,
                              std::size_t said_before);

}  // namespace repose::dem_adapter
