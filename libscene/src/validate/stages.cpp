// Regions and stages.
#include <algorithm>
#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/run_output.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

void check_cylinder(const std::string& what, const RegionCylinder& cylinder) {
  require_finite(what + "axis_start_m", cylinder.start);
  require_finite(what + "axis_end_m", cylinder.end);
  require_positive(what + "radius_m", cylinder.radius_m);
  if (!((cylinder.end - cylinder.start).norm() > 0.0))
    throw InputError(what + "axis_start_m and axis_end_m are the same point; give the two ends");
}

void check_opens(const Case& scene, const Stage& stage, std::set<int>& opened) {
  std::vector<std::string> names;
  for (const Wall& wall : scene.walls) names.push_back(wall.name);
  for (const std::string& name : stage.opens) {
    const std::vector<int> walls = walls_named(scene, name);
    if (walls.empty())
      throw InputError("stage \"" + stage.name + "\": opens = \"" + name +
                       "\" is not a wall; the case has " +
                       (names.empty() ? std::string("none") : listed(names)));
    for (int wall : walls)
      if (!opened.insert(wall).second)
        throw InputError("stage \"" + stage.name + "\": opens = \"" + name +
                         "\" was taken away before; name it once");
  }
}

void check_flow_ends(const Case& scene, const std::string& what, const FlowEnds& ends) {
  const auto region = std::find_if(scene.regions.begin(), scene.regions.end(),
                                   [&](const Region& r) { return r.name == ends.region; });
  if (region == scene.regions.end())
    throw InputError(what + "flow_ends.region = \"" + ends.region +
                     "\" is not a region; add a [[region]] of this name");
  if (region->removes)
    throw InputError(what + "flow_ends.region = \"" + ends.region +
                     "\" removes its particles, so no mass ever leaves it; name the region that "
                     "they come from");
  require_positive(what + "flow_ends.fraction", ends.fraction);
  require_positive(what + "flow_ends.window_s", ends.window_s);
}

void check_coefficients(const std::string& what, const StageCoefficients& all) {
  if (!(all.restitution > 0.0 && all.restitution <= 1.0))
    refuse(what + "restitution", all.restitution, "must be in (0, 1]");
  require_non_negative(what + "mu_s", all.mu_s);
  require_non_negative(what + "mu_r", all.mu_r);
}

}  // namespace

void check_regions(const Case& scene) {
  require_unique_names("region", scene.regions);
  std::set<std::string> columns;
  for (const std::string& column : region_columns(scene))
    if (!columns.insert(column).second)
      throw InputError("two regions have the same column \"" + column +
                       "\" in the output; rename a region or a material");
  for (const Region& region : scene.regions) {
    const std::string what = "region \"" + region.name + "\": ";
    for (int k = 0; k < 3; ++k)
      if (!(region.upper[k] > region.lower[k]))
        refuse(what + "upper bound of " + kAxes[k], region.upper[k],
               "must be above its lower bound " + shortest(region.lower[k]));
    if (region.cylinder) check_cylinder(what, *region.cylinder);
  }
}

void check_stages(const Case& scene) {
  if (scene.stages.empty()) throw InputError("the case has no stage; add [[stage]]");
  require_unique_names("stage", scene.stages);
  std::set<int> opened;
  for (const Stage& stage : scene.stages) {
    const std::string what = "stage \"" + stage.name + "\": ";
    require_positive(what + "duration_s", stage.duration_s);
    require_non_negative(what + "minimum_s", stage.minimum_s);
    if (stage.minimum_s > stage.duration_s)
      refuse(what + "minimum_s", stage.minimum_s,
             "must be at most duration_s = " + shortest(stage.duration_s));
    check_opens(scene, stage, opened);
    if (stage.at_rest) {
      require_positive(what + "at_rest.kinetic_energy_ratio", stage.at_rest->kinetic_energy_ratio);
      require_positive(what + "at_rest.window_s", stage.at_rest->window_s);
      if (!(scene.gravity_m_s2.norm() > 0.0))
        throw InputError(what +
                         "at_rest compares with the weight, but gravity_m_s2 is zero; "
                         "take at_rest out");
    }
    if (stage.flow_ends) check_flow_ends(scene, what, *stage.flow_ends);
    if (stage.coefficients) check_coefficients(what + "coefficients.", *stage.coefficients);
  }
}

}  // namespace repose::scene
