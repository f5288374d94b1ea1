// Ctrl-C and SIGTERM as a flag that long work looks at; a second one ends the program at once.
#pragma once

#include <atomic>

namespace repose::cli {

/// Becomes true at the first SIGINT or SIGTERM after the first call.
const std::atomic<bool>& stop_requested();

}  // namespace repose::cli
