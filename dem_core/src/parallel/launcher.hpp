// Starts the program again as several processes.
#pragma once

#include <csignal>

namespace repose::dem {

/// What tells ranks to write a checkpoint and stop.
inline constexpr int kStopRanks = SIGUSR2;

/// Runs this program with these arguments under mpirun on `ranks` processes and waits. Signals to
/// stop and to write a checkpoint are passed on. Returns the exit code: that of the ranks, or
/// 128 + N, as a shell gives for one process, with a message on stderr that names the rank if one
/// died by signal N. Throws StorageError if mpirun is not there.
int launch_ranks(int ranks, int argc, char** argv);

}  // namespace repose::dem
