// What a case must satisfy before its first step.
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

void check_run(const Case& scene) {
  const double fraction = scene.time_step_rayleigh_fraction;
  require_positive("time_step_rayleigh_fraction", fraction);
  if (fraction > 0.5)
    refuse("time_step_rayleigh_fraction", fraction,
           "must be at most 0.5, else contacts are unstable; 0.1 to 0.3 is usual");
  if (scene.seed >= (1ULL << 63))
    throw InputError("seed = " + std::to_string(scene.seed) + ": must be below 2^63");
  require_finite("gravity_m_s2", scene.gravity_m_s2);
  require_finite("domain.lower_m", scene.lower_m);
  require_finite("domain.upper_m", scene.upper_m);
  for (int k = 0; k < 3; ++k)
    if (!(scene.upper_m[k] > scene.lower_m[k]))
      refuse(std::string("domain.upper_m.") + kAxes[k], scene.upper_m[k],
             "must be above domain.lower_m = " + shortest(scene.lower_m[k]));
  require_non_negative("output.snapshot_interval_s", scene.output.snapshot_interval_s);
  require_positive("output.series_interval_s", scene.output.series_interval_s);
  require_non_negative("output.checkpoint_wall_time_s", scene.output.checkpoint_wall_time_s);
  for (const auto& [name, value] : scene.parameters)
    if (!std::isfinite(value)) refuse("parameters." + name, value, "must be finite");
}

}  // namespace

void validate(const Case& scene) {
  check_run(scene);
  check_materials(scene);
  check_clumps(scene);
  check_walls(scene);
  check_regions(scene);
  check_stages(scene);
  check_motions(scene);
  check_insertion(scene);
  check_pairs_present(scene);
}

}  // namespace repose::scene
