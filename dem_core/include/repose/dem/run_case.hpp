// A whole run: a case in, a run folder out.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "repose/base/error.hpp"
#include "repose/base/progress.hpp"
#include "repose/dem/simulation.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem {

/// What a run is asked to do besides going on.
enum class Request { none, write_checkpoint, stop };

enum class Start {
  where_stopped,  ///< from the checkpoint in the run folder, if there is one
  anew            ///< removes what an earlier run left
};

struct RunControl {
  /// Is told the simulated time and the latest at which the run may end, which comes closer when a
  /// stage ends early; what it throws ends the run, and the folder then holds closed parts but no
  /// run.h5.
  ProgressCallback progress{};
  /// Asked about twice a second, and answered at once.
  std::function<Request()> request{};
  /// Told what a user should know and the log has too: a checkpoint of another build of the
  /// program; contacts that are too soft, when the first of them is seen, and of the deepest when
  /// the run has finished.
  std::function<void(std::string_view)> warn{};
  Start start = Start::where_stopped;
  /// The stage at whose end the run waits, with a checkpoint and without run.h5; empty: none. It
  /// goes on when it is run without, also with a case of which only later stages differ.
  std::string until{};
  Balance balance = Balance::by_cost;  ///< of processes
};

/// Request::stop was followed: the checkpoint is written.
struct RunStopped : SimulationError {
  using SimulationError::SimulationError;
};

/// Runs all stages of a case and writes its run folder (see run_output.hpp). Criteria that end a
/// stage are looked at with each row of the series. Checkpoints are written on request and after
/// each Output::checkpoint_wall_time_s; where one is found, the run goes on from it, and its output
/// is as if it had never stopped. Throws InputError before the first step (a case with another
/// beginning left its checkpoint in the folder, naming what differs; there is no stage
/// RunControl::until), SimulationError, StorageError: then the last
/// checkpoint is still there. Throws RunStopped.
scene::RunSummary run_case(const scene::Case& scene, const std::filesystem::path& run_dir,
                           const RunControl& control = {});

/// The same beside `file`, in the folder `file`.parts, whose run.h5 becomes `file` at the end; then
/// the folder is removed. Where an earlier run of this case was finished but not yet moved, only
/// that is done (but not with Start::anew). Throws InputError if it is to wait: nothing would be in
/// `file`.
scene::RunSummary run_case_into_file(const scene::Case& scene, const std::filesystem::path& file,
                                     const RunControl& control = {});

/// Places the particles of a case and takes no step, so that another program may go on with them.
/// The run folder becomes that of a run without stages: one row of the series, the particles as its
/// only snapshot, of no stage, and in the summary the time step of the case. For one process.
/// Throws as run_case().
scene::RunSummary place_particles(const scene::Case& scene, const std::filesystem::path& run_dir);

}  // namespace repose::dem
