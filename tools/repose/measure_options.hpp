// What `repose measure` is told, and its parts: photographs, runs, mass curves.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/view.hpp"
#include "repose/dem_adapter/view_angle.hpp"
#include "repose/table/table.hpp"

namespace repose::cli {

struct MeasureOptions {
  CommonOptions common;
  std::string input;
  std::string audit;
  // the edge
  std::string shape = "heap", fit = "robust";
  std::optional<double> axis, floor, toe;
  std::vector<double> outlet;
  double from = 0.0, to = 1.0;
  // photographs
  std::optional<double> scale, threshold;
  std::vector<double> level;
  std::vector<int> crop;
  std::string background;
  std::vector<std::string> components;
  // runs
  std::string snapshot, view = "front";
  std::vector<double> window;
  double fastest_m_s = 0.2;
  // segregation
  std::vector<int> slices;
  std::string grid, over_time, initial, output;
  std::vector<double> bins, origin, box;
  double least_fill = 0.0;
  // flow, density, contacts
  std::string flow, stage;
  std::vector<double> flow_window;
  double filter_s = 0.05;
  bool bulk_density = false, contacts = false;
};

/// What there is to say: KPIs, and how they depend on the size of bins where several were given.
struct Measured {
  dem_adapter::Measurement measurement;
  std::optional<table::Table> sizes = std::nullopt;
};

Measured measure_photograph(const MeasureOptions& o);
/// A run's folder or file; options that do not go together throw InputError.
Measured measure_run(const MeasureOptions& o, const CLI::App& command);
/// A table of a load cell: columns time_s and the one named by --flow.
Measured measure_mass_table(const MeasureOptions& o);

/// The edge as told, places in the unit of a run.
dem_adapter::EdgeOptions edge_options(const MeasureOptions& o);
/// The angle of a view, and its slices if they are asked for; writes the audit picture.
dem_adapter::Measurement measured_view(const MeasureOptions& o, const dem_adapter::View& view,
                                       const dem_adapter::EdgeOptions& edge);

}  // namespace repose::cli
