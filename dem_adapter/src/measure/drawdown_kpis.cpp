// KPIs of the draw-down test, after [Hadi2026, section 5.2.3]: silhouette, edge, fitted lines; load
// cell.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/drawdown.hpp"
#include "repose/dem_adapter/edge_angle.hpp"
#include "repose/dem_adapter/run_bulk.hpp"
#include "repose/dem_adapter/silhouette.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kColumn_m = 0.0005;                // of the silhouettes
constexpr double kInFlight_m_s = 0.2;               // faster spheres are dribble, not heap
constexpr double kFlowFrom = 0.15, kFlowTo = 0.65;  // of the discharged mass: the steady part
constexpr double kJammed = 0.5;  // a smaller discharged fraction means an arch over the slot

struct Silhouettes {
  std::vector<Disc> upper, lower;
  double largest_diameter_m = 0.0;
  double discharged_kg = 0.0, total_kg = 0.0;
};

/// Discs at rest above and below the upper floor; masses count every sphere.
Silhouettes discs_of(const scene::Snapshot& snapshot) {
  Silhouettes s;
  for (std::size_t i = 0; i < snapshot.size(); ++i) {
    const auto& x = snapshot.position[i];
    const double mass = snapshot.mass_kg[i];
    s.total_kg += mass;
    if (x.z() < 0.0) s.discharged_kg += mass;
    s.largest_diameter_m = std::max(s.largest_diameter_m, 2.0 * snapshot.radius_m[i]);
    if (snapshot.velocity[i].norm() > kInFlight_m_s) continue;
    (x.z() < 0.0 ? s.lower : s.upper).push_back({x.x(), x.z(), snapshot.radius_m[i]});
  }
  return s;
}

/// The lengths that the KPIs need, from the walls of the case that was run: the scenario's own may
/// have been overridden.
struct Rig {
  double half_width_m, half_slot_m, half_lower_m, floor_m;
};

Rig rig_of(const scene::Case& scene) {
  const auto origin = [&](const char* name) {
    const auto found = scene::walls_named(scene, name);
    if (found.empty())
      throw InputError(fmt::format("the run has no wall \"{}\"; it is not a draw-down", name));
    const scene::Shape& shape = scene.walls[static_cast<std::size_t>(found.front())].shape;
    if (const auto* plane = std::get_if<scene::Plane>(&shape)) return plane->origin;
    if (const auto* rectangle = std::get_if<scene::Rectangle>(&shape)) return rectangle->origin;
    throw InputError(fmt::format(
        "wall \"{}\" of the run is neither plane nor rectangle; it is not a draw-down", name));
  };
  return {.half_width_m = origin("upper_right").x(),
          .half_slot_m = origin("floor_right").x(),
          .half_lower_m = origin("lower_right").x(),
          .floor_m = origin("lower_floor").z()};
}

}  // namespace

bool Drawdown::is_of(const scene::Case& scene) {
  const auto has_stage = [&](const char* name) {
    return std::any_of(scene.stages.begin(), scene.stages.end(),
                       [&](const scene::Stage& stage) { return stage.name == name; });
  };
  for (const char* wall : {"upper_right", "floor_right", "lower_right", "lower_floor"})
    if (scene::walls_named(scene, wall).empty()) return false;
  return has_stage("settle") && has_stage("discharge");
}

Measurement Drawdown::measure(const scene::Run& run) const {
  Measurement m;
  const auto s = discs_of(run.end_of("discharge"));
  if (!(s.total_kg > 0.0)) throw InputError("the last snapshot holds no particles");
  const double fraction = s.discharged_kg / s.total_kg;
  m.details["largest_overlap_ratio"] = run.summary().largest_overlap_ratio;
  m.details["discharged_fraction"] = fraction;
  if (fraction < kJammed) {
    const auto outcome = fraction < 0.005 ? Outcome::nothing_flowed : Outcome::jammed_outlet;
    m.fail(outcome,
           fmt::format("{}: a fraction of {:.3f} was discharged, less than {}; widen the outlet or "
                       "lower the friction",
                       outcome == Outcome::nothing_flowed ? "nothing flowed" : "the outlet jammed",
                       fraction, kJammed));
    return m;
  }
  const auto [half, slot, wall, floor] = rig_of(run.scene());
  const auto slope = silhouette(s.upper, -half, half, kColumn_m);
  const auto shear = slope_angles(slope, -half, -slot, slot, half);
  // One largest diameter for the toe leaves out scattered single spheres.
  const auto repose =
      heap_angles(silhouette(s.lower, -wall, wall, kColumn_m),
                  {.floor_m = floor, .toe_m = s.largest_diameter_m, .reach_m = wall});
  const auto flow = discharge_flow(stage_curve(run, "upper_box", "discharge"),
                                   {.filter_s = 0.0, .window = ShareWindow{kFlowFrom, kFlowTo}});
  m.kpis = {{"shear_angle_deg", shear.mean_deg()},
            {"angle_of_repose_deg", repose.mean_deg()},
            {"discharged_fraction", fraction},
            {"discharged_mass_kg", s.discharged_kg},
            {"mass_flow_kg_s", flow.rate_kg_s}};
  m.details["shear_angle_left_deg"] = shear.left_deg;
  m.details["shear_angle_right_deg"] = shear.right_deg;
  m.details["angle_of_repose_left_deg"] = repose.left_deg;
  m.details["angle_of_repose_right_deg"] = repose.right_deg;
  m.details["heap_half_base_m"] = 0.5 * (repose.left_end_m + repose.right_end_m);
  m.details["time_98_percent_s"] = flow.time_98_s;
  m.drop_undefined_kpis();  // an edge or a mass curve with too few points
  if (repose.left_end_m >= wall || repose.right_end_m >= wall)
    m.warnings.push_back(
        "the heap reached the wall of the lower box, which raises its angle by 1-2 degrees; widen "
        "the box");
  return m;
}

}  // namespace repose::dem_adapter
