// Ctrl-C and SIGTERM as a wish that long work looks at.
#pragma once

#include <atomic>

#include "repose/dem_adapter/campaign.hpp"

namespace repose::cli {

/// What becomes of the runs under way at the first Ctrl-C; at the next one they are ended, and a
/// third ends the program. SIGTERM, which a queue or a shutdown sends, always ends them at once.
enum class FirstInterrupt { lets_runs_end, ends_runs };

/// Becomes Stop::when_runs_end or Stop::now at a signal after the first call, which says so.
const std::atomic<dem_adapter::Stop>& stop_requested(FirstInterrupt first);

}  // namespace repose::cli
