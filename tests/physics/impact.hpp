// A sphere that hits a plane, and tables of what it should do then.
#pragma once

#include <string>
#include <vector>

#include "../dem_core/small_cases.hpp"

namespace repose::physics {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Rebound {
  double vx, vz, w;  ///< w about y
};

/// A sphere hits the rigid plane z = 0 with velocity (vx, 0, -vn) and spin w about y; `steps` is
/// the number of time steps in the contact of an elastic sphere, `gap_steps` that before the touch.
Rebound impact(dem::OneMaterial material, const scene::ContactModel& model, double radius,
               double vx, double vn, double w, double steps, double gap_steps = 0.0);

/// Rows of a CSV file of tests/data/dem; comment and header lines skipped, the first column a name.
struct Row {
  std::string name;
  std::vector<double> values;
};
std::vector<Row> read_rows(const std::string& file);

/// The models a physicist would choose from: tail kept and clipped.
inline scene::ContactModel kept() {
  return {};
}
inline scene::ContactModel clipped() {
  scene::ContactModel model;
  model.tail = scene::Tail::clip;
  return model;
}

}  // namespace repose::physics
