#include "repose/dem_adapter/run_segregation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "case_names.hpp"
#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

using scene::Vec3;
using table::Role;

constexpr double kRounding = 1e-9;  // of sums of masses
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSectorDegrees = 45.0;
constexpr double kReferenceDiameters = 10.0;  // [Hadi2026, section 6.2.3]

std::vector<double> column_of(const Eigen::MatrixXd& values, Eigen::Index k) {
  return {values.col(k).data(), values.col(k).data() + values.rows()};
}

Vec3 default_origin(const Mixture& mixture, GridKind kind) {
  Vec3 lowest = mixture.position.front(), moment = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    lowest = lowest.cwiseMin(mixture.position[i]);
    moment += mixture.mass_kg[i] * mixture.position[i];
    mass += mixture.mass_kg[i];
  }
  const bool has_axis = kind == GridKind::radial || kind == GridKind::circumferential;
  return has_axis ? Vec3(moment / mass) : lowest;
}

/// What one size of bins gives.
struct OneSize {
  Bins bins;
  std::vector<RelativeDeviation> deviation;
  std::vector<double> random;  ///< deviation that chance gives
  double grains_per_bin() const {
    return bins.number.sum() / static_cast<double>(bins.number.rows());
  }
  bool has(std::size_t component) const { return deviation[component].mean > 0.0; }
  /// NaN for a component that lies in none of the bins used.
  double rsd(std::size_t component) const {
    return has(component) ? deviation[component].rsd() : kNaN;
  }
  double rsd_random(std::size_t component) const {
    return has(component) ? random[component] / deviation[component].mean : kNaN;
  }
};

OneSize measured(const Mixture& mixture, const GridOptions& options, const Vec3& origin,
                 double size) {
  OneSize one;
  one.bins = filled(bins_of(mixture, {.kind = options.kind, .size = size, .origin = origin}),
                    options.least_fill);
  one.deviation = relative_deviations(one.bins.amount(options.basis));
  for (std::size_t k = 0; k < mixture.components.size(); ++k)
    one.random.push_back(
        random_deviation(mixture, static_cast<int>(k), options.basis, one.bins.number));
  return one;
}

void add_indices(const Bins& bins, Measurement& m) {
  for (std::size_t k = 0; k < (bins.components.size() == 2 ? 1 : bins.components.size()); ++k) {
    const auto index = segregation_indices(bins, static_cast<int>(k));
    const std::string& name = bins.components[k];
    m.details["panda_tan_" + name] = index.panda_tan;
    m.details["li_" + name] = index.li;
    m.details["mantravadi_tan_" + name] = index.mantravadi_tan;
    m.details["variance_fraction_" + name] = index.variance_fraction;
    m.details["ketterhagen_" + name] = index.ketterhagen;
    m.details["ashton_valentin_" + name] = index.ashton_valentin;
    m.details["lacey_" + name] = index.lacey;
  }
}

table::Table bin_table(const Bins& bins, GridKind kind) {
  table::Table table;
  const char* axes[] = {"cell_x", "cell_y", "cell_z"};
  for (std::size_t d = 0; d < (kind == GridKind::cubic ? 3 : 1); ++d) {
    std::vector<std::int64_t> cells;
    for (const auto& cell : bins.cell) cells.push_back(cell[d]);
    table.add(
        {.name = kind == GridKind::cubic ? axes[d] : "cell", .role = Role::id, .values = cells});
  }
  const Eigen::MatrixXd ratio = normalised_ratios(bins.mass_kg);
  for (std::size_t k = 0; k < bins.components.size(); ++k)
    table.add({.name = "mass_" + bins.components[k] + "_kg",
               .unit = "kg",
               .values = column_of(bins.mass_kg, static_cast<Eigen::Index>(k))});
  for (std::size_t k = 0; k < bins.components.size(); ++k)
    if (const auto column = static_cast<Eigen::Index>(k); bins.mass_kg.col(column).sum() > 0.0)
      table.add({.name = "nmr_" + bins.components[k], .values = column_of(ratio, column)});
  return table;
}

/// The last of the snapshots that hold the most mass: all has been filled in, nothing was taken out
/// yet. With all grains in it, it does not matter which of them it is.
std::size_t fullest_snapshot(const scene::Run& run) {
  if (run.snapshots().empty()) throw InputError("the run has no snapshots");
  std::size_t fullest = 0;
  double most = 0.0;
  for (std::size_t i = 0; i < run.snapshots().size(); ++i) {
    const auto mass = run.snapshot(i).mass_kg;
    const double total = std::accumulate(mass.begin(), mass.end(), 0.0);
    if (total < (1.0 - kRounding) * most) continue;
    fullest = i;
    most = std::max(most, total);
  }
  return fullest;
}

/// What there was at first and what was in the region over time, of each material with grains.
struct Passage {
  std::vector<std::string> components;
  std::vector<double> initial_kg;
  Composition composition;
};

Passage passage_of(const scene::Run& run, const std::string& region,
                   const scene::Snapshot& initial) {
  Passage passage{.composition = {.time_s = run.series().numbers("time_s")}};
  auto& mass = passage.composition.mass_kg;
  mass.resize(static_cast<Eigen::Index>(passage.composition.time_s.size()), 0);
  for (const auto& material : run.scene().materials) {
    double initial_kg = 0.0;
    for (std::size_t i = 0; i < initial.size(); ++i)
      if (initial.materials.at(static_cast<std::size_t>(initial.material[i])) == material.name)
        initial_kg += initial.mass_kg[i];
    const auto in_region =
        run.series().numbers(fmt::format("mass_{}_{}_kg", region, material.name));
    const bool came =
        std::any_of(in_region.begin(), in_region.end(), [](double kg) { return kg > 0.0; });
    if (initial_kg == 0.0 && !came) continue;  // of walls
    if (initial_kg == 0.0)
      throw InputError(fmt::format(
          "'{}' comes into region '{}', but the snapshot of {:.6g} s, which the initial shares are "
          "taken from, has no grains of it; take a later one",
          material.name, region, initial.time_s));
    passage.components.push_back(material.name);
    passage.initial_kg.push_back(initial_kg);
    mass.conservativeResize(Eigen::NoChange, mass.cols() + 1);
    mass.rightCols(1) = Eigen::Map<const Eigen::VectorXd>(in_region.data(), mass.rows());
  }
  if (passage.components.size() < 2)
    throw InputError(fmt::format(
        "the snapshot of {:.6g} s, which the initial shares are taken from, has grains of {} "
        "material; segregation needs two",
        initial.time_s, passage.components.size()));
  return passage;
}

}  // namespace

GridSegregation measure_segregation(const Mixture& mixture, const GridOptions& options) {
  const double reference = reference_diameter_m(mixture);
  std::vector<double> sizes = options.sizes;
  if (sizes.empty())
    sizes.push_back(options.kind == GridKind::circumferential ? kSectorDegrees
                                                              : kReferenceDiameters * reference);
  const Vec3 origin = options.origin.value_or(default_origin(mixture, options.kind));
  const OneSize first = measured(mixture, options, origin, sizes.front());
  GridSegregation result;
  auto& m = result.measurement;
  const std::string grid = to_string(options.kind);
  for (std::size_t k = 0; k < mixture.components.size(); ++k) {
    const std::string& name = mixture.components[k];
    m.kpis[fmt::format("rsd_{}_{}", grid, name)] = first.rsd(k);
    m.details[fmt::format("rsd_random_{}", name)] = first.rsd_random(k);
    m.details[fmt::format("deviation_{}", name)] = first.deviation[k].deviation;
    if (!first.has(k))
      m.warnings.push_back(
          fmt::format("no grain of '{}' lies in the {} bins used; leave out fewer (least fill {}) "
                      "or give a larger size",
                      name, first.bins.cell.size(), options.least_fill));
  }
  m.details["bins"] = static_cast<double>(first.bins.cell.size());
  m.details["grains_per_bin"] = first.grains_per_bin();
  m.details["bin_size"] = sizes.front();
  m.details["reference_diameter_m"] = reference;
  if (mixture.components.size() > 1 && first.grains_per_bin() > 1.0) add_indices(first.bins, m);
  m.drop_undefined_kpis();

  std::vector<double> used, bins, grains;
  std::vector<std::vector<double>> rsd(mixture.components.size()), random = rsd;
  for (const double size : sizes) {
    OneSize one;
    try {
      one = measured(mixture, options, origin, size);
    } catch (const InputError& error) {
      m.warnings.push_back(fmt::format("bins of {:.4g}: {}", size, error.what()));
      continue;
    }
    used.push_back(size);
    bins.push_back(static_cast<double>(one.bins.cell.size()));
    grains.push_back(one.grains_per_bin());
    for (std::size_t k = 0; k < rsd.size(); ++k) {
      rsd[k].push_back(one.rsd(k));
      random[k].push_back(one.rsd_random(k));
    }
  }
  result.sizes.add({.name = "size",
                    .unit = options.kind == GridKind::circumferential ? "deg" : "m",
                    .values = used});
  result.sizes.add({.name = "bins", .values = bins});
  result.sizes.add({.name = "grains_per_bin", .values = grains});
  for (std::size_t k = 0; k < rsd.size(); ++k) {
    result.sizes.add({.name = "rsd_" + mixture.components[k], .values = rsd[k]});
    result.sizes.add({.name = "rsd_random_" + mixture.components[k], .values = random[k]});
  }
  result.bins = bin_table(first.bins, options.kind);
  return result;
}

Measurement measure_slices(const View& view, int horizontal, int vertical) {
  Measurement m;
  for (const auto& [direction, name, count] :
       {std::tuple(SliceDirection::horizontal, "horizontal", horizontal),
        std::tuple(SliceDirection::vertical, "vertical", vertical)}) {
    const Eigen::MatrixXd pixels = pixels_in_slices(view, direction, count);
    const Eigen::VectorXd seen = pixels.colwise().sum();
    if ((seen.array() > 0.0).count() < 2)
      throw InputError(
          "one component only is seen; slices compare two or more (for a photograph, give each "
          "one's colour)");
    const auto deviation = relative_deviations(pixels);
    for (std::size_t k = 0; k < view.components.size(); ++k) {
      const auto pixels_seen = seen[static_cast<Eigen::Index>(k)];
      if (pixels_seen == 0.0) continue;
      m.kpis[fmt::format("rsd_image_{}_{}", name, view.components[k])] = deviation[k].rsd();
      m.details["pixel_share_" + view.components[k]] = pixels_seen / seen.sum();
    }
    m.details[fmt::format("slices_{}", name)] = static_cast<double>(pixels.rows());
  }
  return m;
}

DischargeSegregation measure_discharge_segregation(const scene::Run& run, const std::string& region,
                                                   const DischargeOptions& options) {
  check_region(run.scene(), region);
  const auto initial =
      run.snapshot(options.initial_snapshot ? *options.initial_snapshot : fullest_snapshot(run));
  const auto [components, initial_kg, composition] = passage_of(run, region, initial);
  Eigen::VectorXd share = Eigen::Map<const Eigen::VectorXd>(
      initial_kg.data(), static_cast<Eigen::Index>(initial_kg.size()));
  share /= share.sum();
  const auto over_time = segregation_over_time(composition, share, options.over_time);
  DischargeSegregation result;
  auto& m = result.measurement;
  std::vector<double> time, mass;
  for (const std::size_t row : over_time.used) {
    time.push_back(composition.time_s[row]);
    mass.push_back(composition.mass_kg.row(static_cast<Eigen::Index>(row)).sum());
  }
  m.details["time_min_s"] = time.front();
  m.details["time_max_s"] = time.back();
  m.details["times"] = static_cast<double>(time.size());
  m.details["initial_time_s"] = initial.time_s;
  result.series.add({.name = "time_s", .unit = "s", .values = time});
  result.series.add({.name = "normalised_time", .values = over_time.normalised_time});
  result.series.add({.name = "mass_kg", .unit = "kg", .values = mass});
  for (std::size_t k = 0; k < components.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    m.kpis[fmt::format("si_{}_{}", region, components[k])] = over_time.mean_index[at];
    m.details["initial_share_" + components[k]] = share[at];
    result.series.add({.name = "si_" + components[k], .values = column_of(over_time.index, at)});
    result.series.add(
        {.name = "nmr_" + components[k], .values = column_of(over_time.normalised_ratio, at)});
  }
  return result;
}

}  // namespace repose::dem_adapter
