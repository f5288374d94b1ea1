// Runs a case of spheres between planes and rectangles in LIGGGHTS, as a program of its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "repose/scene/case.hpp"

namespace repose::cross_engine {

/// Whether `liggghts` and `mpirun` are on the PATH.
bool have_liggghts();

struct Frame {
  double time_s = 0.0;
  std::vector<scene::Particle> particles;  ///< in the order of the case
};

struct LiggghtsOptions {
  double time_step_s = 0.0;
  std::int64_t steps = 0;
  std::int64_t frame_interval = 0;  ///< steps
  double skin_m = 0.0;
};

/// Frames at 0 and every interval. The case's particles are the start; its fill and stages do not
/// count, nor walls named in `without`. Works in `folder`, which is left behind. Throws
/// SimulationError with the end of the log if LIGGGHTS fails.
std::vector<Frame> run_liggghts(const scene::Case& scene, const std::vector<std::string>& without,
                                const LiggghtsOptions& options,
                                const std::filesystem::path& folder);

}  // namespace repose::cross_engine
