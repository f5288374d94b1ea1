#include "validate/checks.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {

void refuse(const std::string& quantity, double value, const std::string& what) {
  throw InputError(quantity + " = " + shortest(value) + ": " + what);
}

void require_positive(const std::string& quantity, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) refuse(quantity, value, "must be above 0");
}

void require_non_negative(const std::string& quantity, double value) {
  if (!(value >= 0.0) || !std::isfinite(value)) refuse(quantity, value, "must be at least 0");
}

void require_finite(const std::string& quantity, const Vec3& value) {
  for (int k = 0; k < 3; ++k)
    if (!std::isfinite(value[k]))
      refuse(quantity + "." + kAxes[k], value[k], "must be a finite number");
}

void require_unique(const char* kind, const std::vector<std::string>& names) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty())
      throw InputError(std::string("a ") + kind + " has an empty name; give it one");
    if (name.find('/') != std::string::npos)
      throw InputError(std::string(kind) + " \"" + name +
                       "\": a name must not have a \"/\"; it becomes part of a column's name");
    if (!seen.insert(name).second)
      throw InputError(std::string(kind) + " \"" + name + "\" stands twice; names must differ");
  }
}

void require_box(const Case& scene, const std::string& what, const Vec3& lower, const Vec3& upper) {
  require_finite(what + ".lower_m", lower);
  require_finite(what + ".upper_m", upper);
  for (int k = 0; k < 3; ++k) {
    if (!(upper[k] > lower[k]))
      refuse(what + ".upper_m." + kAxes[k], upper[k],
             "must be above " + what + ".lower_m = " + shortest(lower[k]));
    if (lower[k] < scene.lower_m[k] || upper[k] > scene.upper_m[k])
      throw InputError(what + " from " + shortest(lower[k]) + " to " + shortest(upper[k]) +
                       " m along " + kAxes[k] + " reaches out of the domain; keep it within " +
                       shortest(scene.lower_m[k]) + " and " + shortest(scene.upper_m[k]));
  }
}

bool is_periodic(const Case& scene, int axis) {
  return axis == 0 ? scene.periodic.x : axis == 1 ? scene.periodic.y : scene.periodic.z;
}

std::size_t stage_index(const Case& scene, const std::string& what, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t s = 0; s < scene.stages.size(); ++s) {
    if (scene.stages[s].name == name) return s;
    names.push_back(scene.stages[s].name);
  }
  throw InputError(what + ": stage = \"" + name + "\" is not a stage; the case has " +
                   (names.empty() ? std::string("none") : listed(names)));
}

double longest_time_after_s(const Case& scene, const std::string& what, const std::string& stage) {
  double time = 0.0;
  for (std::size_t s = stage.empty() ? 0 : stage_index(scene, what, stage); s < scene.stages.size();
       ++s)
    time += scene.stages[s].duration_s;
  return time;
}

}  // namespace repose::scene
