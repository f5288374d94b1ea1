// Flow, density, masses and contact forces of a run, under the names that users meet.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "repose/dem_adapter/flow.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/mixture.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

/// The mass in a region of a run from its last maximum on: that is when the outlet opened; all of
/// it if the region is fullest at the end. Throws InputError if the case has no such region.
MassCurve discharge_curve(const scene::Run& run, const std::string& region);
/// The mass (of one material, or of all: "") in a region in a stage, times from its beginning; the
/// first row is what was there just before. Throws InputError if the run has none of them.
MassCurve stage_curve(const scene::Run& run, const std::string& region, const std::string& stage,
                      const std::string& material = "");
/// Begin and end of a stage (default: the last), s. Throws InputError if the run has none such.
std::pair<double, double> stage_span(const scene::Run& run,
                                     const std::optional<std::string>& stage = {});

/// KPIs `mass_flow_kg_s`, `discharged_mass_kg`, `discharged_fraction` (of the first mass; undefined
/// if that is not above 0). Details: the window, the time at which 98 % were out, the unsteadiness.
/// The failure says that nothing flowed or that the window holds too little. Throws InputError for
/// fewer than three points, or as discharge_flow().
Measurement measure_flow(const MassCurve& curve, const FlowOptions& options = {});

/// KPIs `bulk_density_kg_m3`: mass of the grains whose centres lie in `box` over its volume, and
/// `solid_fraction`; the box is cut off at the sides of the domain. That is unbiased for a box
/// inside a bed; near walls and surfaces it is not. Details: the same of the lower and the upper
/// half, mass and number of each component. A warning where the halves differ by more than a
/// fifth. Throws InputError if the box lies outside the domain, holds nothing or is a cylinder.
Measurement measure_bulk_density(const scene::Snapshot& snapshot, const scene::Case& scene,
                                 const scene::Region& box);

/// KPIs `mean_normal_force_A_B_n` of each pair of materials that touches: the mean over contacts
/// and over the rows of the time series in the stage (default: the last). Details: contacts_A_B
/// (mean), largest_normal_force_A_B_n, mean_overlap_ratio_A_B, sliding_fraction_A_B. Throws
/// InputError if the run recorded no contacts, has no such stage, or nothing touches in it.
Measurement measure_contacts(const scene::Run& run, const std::optional<std::string>& stage = {});

}  // namespace repose::dem_adapter
