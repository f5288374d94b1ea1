// KPIs of the draw-down test, after [Hadi2026, section 5.2.3]: silhouette, edge, fitted lines; load
// cell.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/drawdown.hpp"
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

/// Distance from the slot's axis at which a half of the heap ends: the first column lower than one
/// largest diameter (scattered single spheres beyond are left out), or the wall. `side` is -1 or 1.
double heap_end_m(const Profile& heap, double side, double wall_m, double floor_m,
                  double diameter_m) {
  const auto n = static_cast<double>(heap.top_m.size());
  for (double d = 0.5 * heap.column_m; d < wall_m; d += heap.column_m) {
    const double column = std::round((side * d - heap.first_x_m) / heap.column_m);
    if (column < 0.0 || column >= n) break;
    const double top = heap.top_m[static_cast<std::size_t>(column)];
    if (std::isnan(top) || top - floor_m < diameter_m) return d;
  }
  return wall_m;
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

/// When the gate opened: the end of the stage before the discharge.
double opening_time_s(const scene::Run& run) {
  for (const auto& stage : run.summary().stages)
    if (stage.name == "settle") return stage.time_s;
  throw InputError("the run has no stage \"settle\"; it is not a draw-down");
}

struct Flow {
  double mean_kg_s = std::numeric_limits<double>::quiet_NaN();
  double t98_s = std::numeric_limits<double>::quiet_NaN();  ///< after the gate opened
};

/// Least-squares slope of the discharged mass in its steady part, as from a load cell under the
/// upper box.
Flow flow_of(const table::Table& series, double opened_s) {
  const auto time = series.numbers("time_s");
  const auto upper = series.numbers("mass_upper_box_kg");
  Flow flow;
  std::vector<double> t, discharged;
  double initial = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < opened_s - 1e-9) {
      initial = upper[i];
      continue;
    }
    if (std::isnan(initial)) initial = upper[i];
    t.push_back(time[i] - opened_s);
    discharged.push_back(initial - upper[i]);
  }
  if (t.size() < 3 || !(discharged.back() > 0.0)) return flow;
  const double total = discharged.back();
  double n = 0.0, mean_t = 0.0, mean_m = 0.0;
  const auto in_window = [&](double m) { return m >= kFlowFrom * total && m <= kFlowTo * total; };
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (std::isnan(flow.t98_s) && discharged[i] >= 0.98 * total) flow.t98_s = t[i];
    if (!in_window(discharged[i])) continue;
    n += 1.0;
    mean_t += t[i];
    mean_m += discharged[i];
  }
  if (n < 2.0) return flow;
  mean_t /= n;
  mean_m /= n;
  double stt = 0.0, stm = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (in_window(discharged[i])) {
      stt += (t[i] - mean_t) * (t[i] - mean_t);
      stm += (t[i] - mean_t) * (discharged[i] - mean_m);
    }
  if (stt > 0.0) flow.mean_kg_s = stm / stt;
  return flow;
}

}  // namespace

Measurement Drawdown::measure(const scene::Run& run) const {
  Measurement m;
  const auto s = discs_of(run.end_of("discharge"));
  if (!(s.total_kg > 0.0)) throw InputError("the last snapshot holds no particles");
  const double fraction = s.discharged_kg / s.total_kg;
  m.details["largest_overlap_ratio"] = run.summary().largest_overlap_ratio;
  m.details["discharged_fraction"] = fraction;
  if (fraction < kJammed) {
    m.failure = fmt::format(
        "{}: a fraction of {:.3f} was discharged, less than {}; widen the outlet or lower the "
        "friction",
        fraction < 0.005 ? "nothing flowed" : "the outlet jammed", fraction, kJammed);
    return m;
  }
  const auto [half, slot, wall, floor] = rig_of(run.scene());
  const auto slope = silhouette(s.upper, -half, half, kColumn_m);
  const auto left = fit_line(slope, -half, -slot), right = fit_line(slope, slot, half);
  const auto heap = silhouette(s.lower, -wall, wall, kColumn_m);
  const double end_left = heap_end_m(heap, -1.0, wall, floor, s.largest_diameter_m);
  const double end_right = heap_end_m(heap, 1.0, wall, floor, s.largest_diameter_m);
  const auto heap_left = fit_line(heap, -end_left, 0.0),
             heap_right = fit_line(heap, 0.0, end_right);
  // Downwards to the slot above, upwards to the axis below: a slope of the wrong sign counts
  // negative.
  const auto signed_angle = [](const FittedLine& line, double sign) {
    return sign * line.slope < 0.0 ? -line.angle_deg() : line.angle_deg();
  };
  const double shear_left = signed_angle(left, -1.0), shear_right = signed_angle(right, 1.0);
  const double repose_left = signed_angle(heap_left, 1.0),
               repose_right = signed_angle(heap_right, -1.0);

  const auto flow = flow_of(run.series(), opening_time_s(run));
  m.kpis = {{"shear_angle_deg", 0.5 * (shear_left + shear_right)},
            {"angle_of_repose_deg", 0.5 * (repose_left + repose_right)},
            {"discharged_fraction", fraction},
            {"discharged_mass_kg", s.discharged_kg},
            {"mass_flow_kg_s", flow.mean_kg_s}};
  m.details["shear_angle_left_deg"] = shear_left;
  m.details["shear_angle_right_deg"] = shear_right;
  m.details["angle_of_repose_left_deg"] = repose_left;
  m.details["angle_of_repose_right_deg"] = repose_right;
  m.details["heap_half_base_m"] = 0.5 * (end_left + end_right);
  m.details["time_98_percent_s"] = flow.t98_s;
  for (const auto& [name, value] : m.kpis)
    if (!std::isfinite(value) && m.failure.empty())
      m.failure =
          fmt::format("{} is undefined: its edge or its mass curve has too few points", name);
  if (!m.failure.empty()) m.kpis.clear();
  std::erase_if(m.details, [](const auto& detail) { return !std::isfinite(detail.second); });
  if (end_left >= wall || end_right >= wall)
    m.warnings.push_back(
        "the heap reached the wall of the lower box, which raises its angle by 1-2 degrees; widen "
        "the box");
  return m;
}

}  // namespace repose::dem_adapter
