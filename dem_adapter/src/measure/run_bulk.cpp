#include "repose/dem_adapter/run_bulk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "case_names.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kUnevenHalves = 0.2;
constexpr double kUnsteady = 0.25;

/// The part of a box within the domain.
scene::Region clipped(const scene::Case& scene, scene::Region box) {
  if (box.cylinder)
    throw InputError(fmt::format(
        "region '{}' is a cylinder; bulk density needs a box inside the bed", box.name));
  box.lower = box.lower.cwiseMax(scene.lower_m);
  box.upper = box.upper.cwiseMin(scene.upper_m);
  if (!(box.lower.array() < box.upper.array()).all())
    throw InputError("the box lies outside the domain of the case");
  return box;
}

/// Mass and volume of solid in a box, over its volume.
struct Density {
  double bulk_kg_m3 = 0.0, solid = 0.0;
};
Density density_in(const Mixture& mixture, const scene::Region& box) {
  Density density;
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    if (!is_inside(box, mixture.position[i])) continue;
    density.bulk_kg_m3 += mixture.mass_kg[i];
    density.solid += mixture.volume_m3[i];
  }
  const double volume = (box.upper - box.lower).prod();
  density.bulk_kg_m3 /= volume;
  density.solid /= volume;
  return density;
}

}  // namespace

std::pair<double, double> stage_span(const scene::Run& run,
                                     const std::optional<std::string>& name) {
  const auto& stages = run.summary().stages;
  if (stages.empty()) throw InputError("the run has no stages");
  std::vector<std::string> known;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    known.push_back(stages[i].name);
    if (name ? stages[i].name == *name : i + 1 == stages.size())
      return {i > 0 ? stages[i - 1].time_s : 0.0, stages[i].time_s};
  }
  throw InputError(fmt::format("the run has no stage '{}'; it has {}", *name, listed(known)));
}

MassCurve discharge_curve(const scene::Run& run, const std::string& region) {
  check_region(run.scene(), region);
  MassCurve curve{.time_s = run.series().numbers("time_s"),
                  .mass_kg = run.series().numbers("mass_" + region + "_kg")};
  if (curve.mass_kg.empty()) return curve;
  const double most = *std::max_element(curve.mass_kg.begin(), curve.mass_kg.end());
  const auto opened = std::find(curve.mass_kg.rbegin(), curve.mass_kg.rend(), most);
  const auto before = curve.mass_kg.rend() - opened - 1;
  if (opened == curve.mass_kg.rbegin()) return curve;  // it never opened
  curve.time_s.erase(curve.time_s.begin(), curve.time_s.begin() + before);
  curve.mass_kg.erase(curve.mass_kg.begin(), curve.mass_kg.begin() + before);
  return curve;
}

MassCurve stage_curve(const scene::Run& run, const std::string& region, const std::string& stage,
                      const std::string& material) {
  check_region(run.scene(), region);
  const auto [from, to] = stage_span(run, stage.empty() ? std::nullopt : std::optional(stage));
  const double rounding = 1e-9 * std::max(to, 1.0);
  const auto time = run.series().numbers("time_s");
  const auto mass = run.series().numbers(
      material.empty() ? "mass_" + region + "_kg" : "mass_" + region + "_" + material + "_kg");
  MassCurve curve;
  std::optional<double> before;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < from - rounding) {
      before = mass[i];
    } else if (time[i] <= to + rounding) {
      curve.time_s.push_back(time[i] - from);
      curve.mass_kg.push_back(mass[i]);
    }
  }
  // An outlet opens at the end of the stage before: what was there just before is what flows.
  if (!curve.mass_kg.empty() && before) curve.mass_kg.front() = *before;
  return curve;
}

Measurement measure_flow(const MassCurve& curve, const FlowOptions& options) {
  if (curve.time_s.size() < 3)
    throw InputError(fmt::format(
        "the mass curve has {} point{}, at least 3 are needed; record more rows a second",
        curve.time_s.size(), curve.time_s.size() == 1 ? "" : "s"));
  const Flow flow = discharge_flow(curve, options);
  Measurement m;
  if (!(flow.discharged_kg > 0.0)) {
    m.fail(Outcome::nothing_flowed, "nothing flowed: the mass does not fall");
    return m;
  }
  if (!std::isfinite(flow.rate_kg_s)) {
    m.fail(Outcome::non_finite,
           "mass_flow_kg_s is undefined: fewer than two points of the mass curve lie in the "
           "window; widen it");
    return m;
  }
  m.kpis = {{"mass_flow_kg_s", flow.rate_kg_s},
            {"discharged_mass_kg", flow.discharged_kg},
            {"discharged_fraction", flow.discharged_kg / std::max(curve.mass_kg.front(), 0.0)}};
  m.details = {{"window_from_s", flow.from_s},
               {"window_to_s", flow.to_s},
               {"opened_s", curve.time_s.front()},
               {"time_98_percent_s", flow.time_98_s - curve.time_s.front()},
               {"unsteadiness", flow.unsteadiness}};
  if (flow.unsteadiness > kUnsteady)
    m.warnings.push_back(fmt::format(
        "the rate in the window deviates from its mean by {:.0f} %: the flow is not steady there, "
        "or the filter too narrow",
        100.0 * flow.unsteadiness));
  m.drop_undefined_kpis();  // the fraction of a load cell that was set to zero first
  return m;
}

Measurement measure_bulk_density(const scene::Snapshot& snapshot, const scene::Case& scene,
                                 const scene::Region& where) {
  const scene::Region box = clipped(scene, where);
  const Mixture mixture = mixture_of(snapshot, scene, box);
  const Density whole = density_in(mixture, box);
  scene::Region lower = box, upper = box;
  lower.upper.z() = upper.lower.z() = 0.5 * (box.lower.z() + box.upper.z());
  const double below = density_in(mixture, lower).bulk_kg_m3;
  const double above = density_in(mixture, upper).bulk_kg_m3;
  Measurement m;
  m.kpis = {{"bulk_density_kg_m3", whole.bulk_kg_m3}, {"solid_fraction", whole.solid}};
  m.details = {{"bulk_density_lower_half_kg_m3", below}, {"bulk_density_upper_half_kg_m3", above}};
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    const auto& name = mixture.components[static_cast<std::size_t>(mixture.component[i])];
    m.details["mass_" + name + "_kg"] += mixture.mass_kg[i];
    m.details["grains_" + name] += 1.0;
  }
  if (std::abs(above - below) > kUnevenHalves * whole.bulk_kg_m3)
    m.warnings.push_back(
        "the upper and the lower half of the box differ by more than a fifth: it reaches out of "
        "the "
        "bed, or holds too few grains");
  return m;
}

Measurement measure_contacts(const scene::Run& run, const std::optional<std::string>& stage) {
  const auto [from, to] = stage_span(run, stage);
  const auto contacts = run.contacts();
  const auto time = contacts.numbers("time_s");
  const double rounding = 1e-9 * std::max(to, 1.0);
  Measurement m;
  for (const auto& name : contacts.names()) {
    const std::string prefix = "contacts_";
    if (!name.starts_with(prefix)) continue;
    const std::string pair = name.substr(prefix.size());
    const auto count = contacts.numbers(name);
    const auto force = contacts.numbers("mean_normal_force_" + pair + "_n");
    const auto largest = contacts.numbers("largest_normal_force_" + pair + "_n");
    const auto overlap = contacts.numbers("mean_overlap_ratio_" + pair);
    const auto sliding = contacts.numbers("sliding_fraction_" + pair);
    double rows = 0.0, touching = 0.0, force_sum = 0.0, overlap_sum = 0.0, sliding_sum = 0.0;
    double top = 0.0;
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (time[i] <= from + rounding || time[i] > to + rounding) continue;
      rows += 1.0;
      touching += count[i];
      force_sum += count[i] * force[i];
      overlap_sum += count[i] * overlap[i];
      sliding_sum += count[i] * sliding[i];
      top = std::max(top, largest[i]);
    }
    if (touching == 0.0) continue;
    m.kpis["mean_normal_force_" + pair + "_n"] = force_sum / touching;
    m.details["contacts_" + pair] = touching / rows;
    m.details["largest_normal_force_" + pair + "_n"] = top;
    m.details["mean_overlap_ratio_" + pair] = overlap_sum / touching;
    m.details["sliding_fraction_" + pair] = sliding_sum / touching;
  }
  if (m.kpis.empty())
    throw InputError(fmt::format("nothing touches between {:.6g} and {:.6g} s", from, to));
  return m;
}

}  // namespace repose::dem_adapter
