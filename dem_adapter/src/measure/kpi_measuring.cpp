// KPIs by definition from a run, by the functions that `repose measure` uses, too.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/kpi_definition.hpp"
#include "repose/dem_adapter/run_bulk.hpp"
#include "scenario/expressions.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kNothing = 0.005;  // a smaller share that left is nothing

/// One KPI: its value, how it came about, or why the run has no KPIs at all.
struct OneKpi {
  double value = 0.0;
  std::map<std::string, double> details{};
  std::vector<std::string> warnings{};
  Outcome outcome = Outcome::finished;  ///< or nothing_flowed, jammed_outlet
  std::string failure{};
};

OneKpi failed(Outcome outcome, std::string sentence) {
  return {.outcome = outcome, .failure = std::move(sentence)};
}

/// A value of a measurement, with its details.
OneKpi picked(const Measurement& m, const std::map<std::string, double>& from,
              const std::string& name) {
  if (is_failure(m.outcome)) {
    if (m.outcome == Outcome::nothing_flowed) return failed(m.outcome, m.failure);
    throw InputError(m.failure);
  }
  const auto it = from.find(name);
  if (it == from.end()) throw InputError(fmt::format("the run has no {}", name));
  return {.value = it->second, .details = m.details, .warnings = m.warnings};
}

struct Measure {
  const scene::Run& run;
  const Expressions& names;

  /// The region of this name; all of space if there is no name.
  scene::Region region(const std::string& name) const {
    for (const auto& one : run.scene().regions)
      if (one.name == name) return one;
    if (!name.empty()) throw InputError(fmt::format("the run has no region \"{}\"", name));
    constexpr double kFar = std::numeric_limits<double>::infinity();
    return {.name = "", .lower = {-kFar, -kFar, -kFar}, .upper = {kFar, kFar, kFar}};
  }
  std::string stage(const std::string& name) const {
    if (!name.empty()) return name;
    if (run.summary().stages.empty()) throw InputError("the run has no stages");
    return run.summary().stages.back().name;
  }
  std::vector<scene::Snapshot> snapshots(const std::string& name, Sampled sampled) const {
    if (sampled == Sampled::at_end) return {run.end_of(stage(name))};
    std::vector<scene::Snapshot> all;
    for (std::size_t i = 0; i < run.snapshots().size(); ++i)
      if (run.snapshots()[i].stage == stage(name)) all.push_back(run.snapshot(i));
    if (all.empty()) throw InputError(fmt::format("no snapshot of stage \"{}\"", stage(name)));
    return all;
  }

  ViewAngle angle(const AngleKpi& kpi, const scene::Snapshot& grains,
                  ViewDirection direction) const {
    const scene::Region where = region(kpi.region);
    const int across = direction == ViewDirection::along_y ? 0 : 1;
    const auto finite = [](double end) {
      return std::isfinite(end) ? std::optional(end) : std::nullopt;
    };
    const ParticleViewOptions options{.direction = direction,
                                      .left_m = finite(where.lower[across]),
                                      .right_m = finite(where.upper[across]),
                                      .bottom_m = finite(where.lower.z()),
                                      .fastest_m_s = kpi.fastest_m_s,
                                      .region = where};
    EdgeOptions edge = kpi.edge;
    if (!edge.floor_m) edge.floor_m = finite(where.lower.z());
    return measure_angle(view_of_particles(grains, options), edge);
  }
  OneKpi operator()(const AngleKpi& kpi) const {
    OneKpi result;
    std::vector<double> angles;
    for (const auto& snapshot : snapshots(kpi.stage, kpi.sampled))
      for (const auto direction : kpi.seen_along) {
        const ViewAngle seen = angle(kpi, snapshot, direction);
        angles.push_back(kpi.side == Side::left    ? seen.angles.left_deg
                         : kpi.side == Side::right ? seen.angles.right_deg
                                                   : seen.angles.mean_deg());
        result.details = seen.measurement.details;
        result.warnings = seen.measurement.warnings;
      }
    const auto n = static_cast<double>(angles.size());
    result.value = std::accumulate(angles.begin(), angles.end(), 0.0) / n;
    if (angles.size() == 1) return result;
    double squares = 0.0;
    for (const double one : angles) squares += std::pow(one - result.value, 2);
    result.details = {{"views", n}, {"deviation_deg", std::sqrt(squares / (n - 1.0))}};
    return result;
  }

  /// Why a discharge cannot be used; empty if it can.
  static OneKpi jam(double first_kg, double out_kg, double jammed_below) {
    const double share = out_kg / first_kg;
    if (!(first_kg > 0.0) || !(share > 0.0) || (jammed_below > 0.0 && share < kNothing))
      return failed(Outcome::nothing_flowed, "nothing flowed out of the region");
    if (share < jammed_below)
      return failed(
          Outcome::jammed_outlet,
          fmt::format("the outlet jammed: a fraction of {:.3f} flowed out, less than {}; widen the "
                      "outlet or lower the friction",
                      share, shortest(jammed_below)));
    return {};
  }
  OneKpi operator()(const MassFlowKpi& kpi) const {
    const MassCurve curve = stage_curve(run, kpi.region, stage(kpi.stage));
    if (curve.mass_kg.empty()) throw InputError("the stage has no rows of the time series");
    const double first = curve.mass_kg.front();
    OneKpi jammed = jam(first, first - curve.mass_kg.back(), kpi.jammed_below);
    if (is_failure(jammed.outcome)) return jammed;
    const auto m = measure_flow(curve, kpi.flow);
    return picked(m, m.kpis, "mass_flow_kg_s");
  }
  OneKpi operator()(const MassKpi& kpi) const {
    const MassCurve curve = stage_curve(run, kpi.region, stage(kpi.stage), kpi.material);
    if (curve.mass_kg.empty()) throw InputError("the stage has no rows of the time series");
    if (!kpi.time_s) return {.value = curve.mass_kg.back()};
    const double last = curve.time_s.back();
    if (*kpi.time_s > last * (1.0 + 1e-9))
      throw InputError(fmt::format("time_s = {}: the stage ended after {} s", shortest(*kpi.time_s),
                                   shortest(last)));
    OneKpi result;
    for (std::size_t i = 0; i < curve.time_s.size(); ++i)
      if (i == 0 || curve.time_s[i] <= *kpi.time_s * (1.0 + 1e-9)) result.value = curve.mass_kg[i];
    return result;
  }
  OneKpi operator()(const FractionKpi& kpi) const {
    const MassCurve curve = stage_curve(run, kpi.region, stage(kpi.stage), kpi.material);
    if (curve.mass_kg.empty()) throw InputError("the stage has no rows of the time series");
    const double first = curve.mass_kg.front(), out = first - curve.mass_kg.back();
    if (!(first > 0.0)) throw InputError("the region held nothing when the stage began");
    if (kpi.jammed_below > 0.0) {
      OneKpi jammed = jam(first, out, kpi.jammed_below);
      if (is_failure(jammed.outcome)) return jammed;
    }
    return {.value = out / first, .details = {{"out_kg", out}}};
  }
  OneKpi operator()(const BulkDensityKpi& kpi) const {
    const auto m =
        measure_bulk_density(run.end_of(stage(kpi.stage)), run.scene(), region(kpi.region));
    return picked(m, m.kpis, "bulk_density_kg_m3");
  }
  OneKpi operator()(const SegregationOverTimeKpi& kpi) const {
    const auto m = measure_discharge_segregation(run, kpi.region).measurement;
    return picked(m, m.kpis, fmt::format("si_{}_{}", kpi.region, kpi.material));
  }
  OneKpi operator()(const GridSegregationKpi& kpi) const {
    const auto mixture = mixture_of(run.end_of(stage(kpi.stage)), run.scene(), region(kpi.region));
    const auto m = measure_segregation(mixture, kpi.grid).measurement;
    if (kpi.index == "rsd")
      return picked(m, m.kpis, fmt::format("rsd_{}_{}", to_string(kpi.grid.kind), kpi.material));
    return picked(m, m.details, kpi.index + "_" + kpi.material);
  }
  OneKpi operator()(const DurationKpi& kpi) const {
    const auto [from, to] = stage_span(run, stage(kpi.stage));
    if (kpi.region.empty()) return {.value = to - from};
    const MassCurve curve = stage_curve(run, kpi.region, stage(kpi.stage));
    if (curve.mass_kg.empty()) throw InputError("the stage has no rows of the time series");
    const double first = curve.mass_kg.front(), out = first - curve.mass_kg.back();
    if (!(out > 0.0)) return failed(Outcome::nothing_flowed, "nothing flowed out of the region");
    for (std::size_t i = 0; i < curve.time_s.size(); ++i)
      if (first - curve.mass_kg[i] >= kpi.share * out) return {.value = curve.time_s[i]};
    throw InputError("the region is fuller at the end than before");
  }
  OneKpi operator()(const WallLoadKpi& kpi) const {
    const auto [from, to] = stage_span(run, stage(kpi.stage));
    const auto loads = run.walls();
    const auto time = loads.numbers("time_s");
    const double rounding = 1e-9 * std::max(to, 1.0);
    const bool is_force = kpi.load == WallLoadKpi::Load::force;
    scene::Vec3 sum = scene::Vec3::Zero();
    double span = 0.0;
    for (const int w : scene::walls_named(run.scene(), kpi.wall)) {
      const std::string wall = run.scene().walls[static_cast<std::size_t>(w)].name;
      span = 0.0;
      for (int k = 0; k < 3; ++k) {
        const std::string axis(1, "xyz"[k]);
        const auto load = loads.numbers(is_force ? "f" + axis + "_" + wall + "_n"
                                                 : "t" + axis + "_" + wall + "_n_m");
        for (std::size_t i = 0; i < time.size(); ++i) {
          if (time[i] <= from + rounding || time[i] > to + rounding) continue;
          const double since = time[i] - (i > 0 ? time[i - 1] : 0.0);  // what the row is a mean of
          sum[k] += load[i] * since;
          if (k == 0) span += since;
        }
      }
    }
    if (!(span > 0.0)) throw InputError("no loads on the wall were recorded in the stage");
    const scene::Vec3 mean = sum / span;
    using Component = WallLoadKpi::Component;
    return {.value = kpi.component == Component::norm ? mean.norm()
                                                      : mean[static_cast<int>(kpi.component)],
            .details = {{"x", mean.x()}, {"y", mean.y()}, {"z", mean.z()}}};
  }
  OneKpi operator()(const ContactForceKpi& kpi) const {
    const auto m = measure_contacts(run, stage(kpi.stage));
    const auto name = [](const std::string& a, const std::string& b) {
      return fmt::format("mean_normal_force_{}_{}_n", a, b);
    };
    const auto one = name(kpi.first, kpi.second);
    return picked(m, m.kpis, m.kpis.count(one) > 0 ? one : name(kpi.second, kpi.first));
  }
  OneKpi operator()(const FormulaKpi& kpi) const {
    return {.value = Expressions(names).value(kpi.formula)};
  }
};

}  // namespace

Measurement measure_kpis(const std::vector<KpiDefinition>& kpis, const scene::Run& run,
                         const ParameterValues& names) {
  Measurement m;
  m.details["largest_overlap_ratio"] = run.summary().largest_overlap_ratio;
  Expressions known;
  for (const auto& [name, value] : names) known.define(name, value);
  std::vector<std::string> reasons;
  for (const auto& kpi : kpis) {
    OneKpi one;
    try {
      one = std::visit(Measure{run, known}, kpi.kind);
    } catch (const InputError& error) {
      reasons.push_back(fmt::format("{}: {}", kpi.name, error.what()));
      continue;
    }
    if (is_failure(one.outcome)) {
      m.fail(one.outcome, fmt::format("{}: {}", kpi.name, one.failure));
      return m;
    }
    if (!std::isfinite(one.value)) {
      reasons.push_back(fmt::format("{}: is not finite", kpi.name));
      continue;
    }
    m.kpis[kpi.name] = one.value;
    known.define(kpi.name, one.value);
    for (const auto& [name, value] : one.details)
      if (std::isfinite(value)) m.details[kpi.name + "." + name] = value;
    for (const auto& warning : one.warnings) m.warnings.push_back(kpi.name + ": " + warning);
  }
  if (reasons.empty()) return m;
  m.outcome = Outcome::kpi_undefined;
  m.failure = "undefined: " + fmt::format("{}", fmt::join(reasons, "; "));
  return m;
}

}  // namespace repose::dem_adapter
