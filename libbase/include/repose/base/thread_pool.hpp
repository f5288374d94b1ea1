// Independent tasks on several threads, with results that do not depend on their number.
#pragma once

#include <cstddef>
#include <functional>

namespace repose {

/// Calls task(0) ... task(n-1), on at most `threads` threads (0: one for each processor). A task
/// may only write what belongs to its own index. If tasks throw, the rest is not started and the
/// exception of the lowest index that threw is rethrown.
void parallel_for(std::size_t n, unsigned threads, const std::function<void(std::size_t)>& task);

}  // namespace repose
