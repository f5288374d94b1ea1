// Segregation of a run or a view: which bins, which share is the initial one, under which names.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/segregation.hpp"
#include "repose/scene/run_output.hpp"
#include "repose/table/table.hpp"

namespace repose::dem_adapter {

struct GridOptions {
  GridKind kind = GridKind::radial;
  /// Sizes of a bin, m (degrees for sectors); the first one gives the KPIs, all of them show how
  /// much these depend on it. Default: ten reference diameters [Hadi2026, section 6.2.3], sectors
  /// of 45 degrees.
  std::vector<double> sizes{};
  /// Default: the lowest coordinates of the grains; for rings and sectors their centre of mass.
  std::optional<scene::Vec3> origin{};
  Basis basis = Basis::mass;
  double least_fill = 0.0;  ///< see filled()
};

struct GridSegregation {
  /// KPIs `rsd_KIND_COMPONENT`; undefined for a component that lies in none of the bins used.
  /// Details: the same of a random mixture, deviations, indices of Table 2.2 (for two components of
  /// the one named first), bins, grains a bin, reference diameter.
  Measurement measurement;
  /// One row a size: size, bins, grains_per_bin, rsd_COMPONENT, rsd_random_COMPONENT (NaN where
  /// undefined).
  table::Table sizes;
  /// One row a bin of the first size: cell, mass_COMPONENT_kg, nmr_COMPONENT (not of those that lie
  /// in none of the bins used).
  table::Table bins;
};

/// Throws InputError if the first size leaves fewer than two bins; a larger one is left out.
GridSegregation measure_segregation(const Mixture& mixture, const GridOptions& options = {});

/// Slices of a view [Hadi2026, Table 5.2]: KPIs `rsd_image_horizontal_COMPONENT`,
/// `rsd_image_vertical_COMPONENT` for components that are seen. The thesis uses 6 and 3 slices.
/// Throws InputError if only one is seen.
Measurement measure_slices(const View& view, int horizontal = 6, int vertical = 3);

struct DischargeOptions {
  /// Index of the snapshot whose grains give the initial shares. Default: the last of those that
  /// hold the most mass, when all has been filled in and nothing was taken out yet.
  std::optional<std::size_t> initial_snapshot{};
  OverTimeOptions over_time{};
};

struct DischargeSegregation {
  /// KPIs `si_REGION_COMPONENT`, means over time, of every material with grains, whether or not it
  /// comes into the region. Details: the times t_min and t_max, the initial shares and their time,
  /// the number of rows.
  Measurement measurement;
  /// One row a time: time_s, normalised_time, mass_kg, si_COMPONENT, nmr_COMPONENT.
  table::Table series;
};

/// The composition of what is in a region of the case over time. Throws InputError if the case has
/// no such region, if the initial snapshot has grains of one material only or lacks one that comes
/// into the region, or as segregation_over_time().
DischargeSegregation measure_discharge_segregation(const scene::Run& run, const std::string& region,
                                                   const DischargeOptions& options = {});

}  // namespace repose::dem_adapter
