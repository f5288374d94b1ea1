// How far a run has come, besides its simulation: what a checkpoint holds of it.
#pragma once

#include "output/records.hpp"
#include "output/stage_end.hpp"
#include "repose/dem/checkpoint.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem {

struct RunState {
  std::size_t stage = 0;       ///< that is under way, in Case::stages
  bool is_begun = false;       ///< that stage; if not, the one before has just ended
  std::int64_t last_step = 0;  ///< of this stage, at most
  StageWatch::Progress watch;
  scene::SeriesRow last_row;    ///< the last that was written
  double weight_scale_j = 0.0;  ///< of that row
  double latest_end_s = 0.0;    ///< of the run, as known from what stages have ended
  std::vector<scene::StageEnd> ends;
  DeepContact deepest;  ///< of the run
  double sphere_steps = 0.0;
  double wall_time_s = 0.0, processor_time_s = 0.0;
  scene::OutputPosition output;
};

/// Adds the tables /stage_ends, /stage_masses, /vtp_poses and attributes.
void add_to(Checkpoint& checkpoint, const RunState& state);
/// Throws StorageError if the checkpoint is not one of a run.
RunState run_state_of(const Checkpoint& checkpoint);

}  // namespace repose::dem
