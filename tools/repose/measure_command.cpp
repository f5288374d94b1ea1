// repose measure: KPIs of a run, a photograph or a load cell, by the same code.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "measure_options.hpp"
#include "measurement_text.hpp"
#include "repose/base/error.hpp"

namespace repose::cli {
namespace {

constexpr std::initializer_list<const char*> kPhotographOnly{
    "--scale", "--threshold", "--crop", "--background", "--component", "--level"};
constexpr std::initializer_list<const char*> kSnapshotOnly{
    "--snapshot",  "--view",         "--window",     "--fastest", "--grid",
    "--bin",       "--origin",       "--least-fill", "--box",     "--output",
    "--over-time", "--bulk-density", "--contacts",   "--stage",   "--initial"};
constexpr std::initializer_list<const char*> kFlowOnly{"--flow", "--flow-window", "--filter"};

bool is_run(const std::filesystem::path& input) {
  return std::filesystem::is_directory(input) || input.extension() == ".h5";
}

/// One row a size of bins.
void print_sizes(const table::Table& sizes) {
  fmt::print("\n");
  for (const auto& name : sizes.names()) fmt::print("{:>20}", name);
  fmt::print("\n");
  for (std::size_t row = 0; row < sizes.rows(); ++row) {
    for (const auto& name : sizes.names()) fmt::print("{:>20.5g}", sizes.numbers(name)[row]);
    fmt::print("\n");
  }
}

void print(const MeasureOptions& o, const Measured& measured) {
  if (!o.common.json) {
    print_measurement(measured.measurement);
    if (measured.sizes && o.bins.size() > 1) print_sizes(*measured.sizes);
    return;
  }
  auto json = measurement_json(measured.measurement);
  if (measured.sizes)
    for (const auto& name : measured.sizes->names())
      json["sizes"][name] = measured.sizes->numbers(name);
  fmt::print("{}\n", json.dump(2));
}

void measure(const MeasureOptions& o, const CLI::App& command) {
  Measured measured;
  if (is_run(o.input)) {
    refuse_options(command, kPhotographOnly, "for a run");
    measured = measure_run(o, command);
  } else if (std::filesystem::path(o.input).extension() == ".csv") {
    refuse_options(command, kPhotographOnly, "for a table");
    refuse_options(command, kSnapshotOnly, "for a table");
    if (o.flow.empty())
      throw InputError(
          "a table is measured for a mass flow; name its column of masses: --flow NAME");
    measured = measure_mass_table(o);
  } else {
    refuse_options(command, kSnapshotOnly, "for a photograph");
    refuse_options(command, kFlowOnly, "for a photograph");
    measured = measure_photograph(o);
  }
  print(o, measured);
  if (is_failure(measured.measurement.outcome)) throw SimulationError(measured.measurement.failure);
}

void add_edge_options(CLI::App& command, MeasureOptions& o) {
  command
      .add_option("--shape", o.shape,
                  "what the edge is: a heap, the slopes at an outlet, or\n"
                  "one surface, as in a drum")
      ->check(CLI::IsMember({"heap", "slopes", "surface"}))
      ->capture_default_str();
  command.add_option("--axis", o.axis, "x that divides the heap; default: middle of its base");
  command.add_option("--floor", o.floor, "z or row of the floor; default: the lowest grain");
  command.add_option("--toe", o.toe,
                     "the heap ends where it is lower than this above the floor;\n"
                     "default: the largest grain, or 2 % of a photographed heap");
  command.add_option("--outlet", o.outlet, "LEFT,RIGHT: x of the ends of the outlet (slopes)")
      ->delimiter(',')
      ->expected(2);
  command.add_option("--from", o.from, "use the edge from this fraction of the height ...")
      ->capture_default_str();
  command.add_option("--to", o.to, "... to this one")->capture_default_str();
  command.add_option("--fit", o.fit, "of the lines: robust leaves outliers out")
      ->check(CLI::IsMember({"robust", "least-squares"}))
      ->capture_default_str();
  command.add_option("--audit", o.audit, "write an SVG picture of what was fitted");
  command
      .add_option("--slices", o.slices,
                  "HORIZONTAL,VERTICAL: also segregation over so many slices of what\n"
                  "is seen, e.g. 6,3")
      ->delimiter(',')
      ->expected(2)
      ->check(CLI::Range(2, 1000));
}

void add_photograph_options(CLI::App& command, MeasureOptions& o) {
  command.add_option("--scale", o.scale, "m per pixel; angles need none")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--level", o.level,
                  "COLUMN,ROW,COLUMN,ROW: two points that should be level, as on the\n"
                  "floor's line; the picture is turned about its middle first of all")
      ->delimiter(',')
      ->expected(4);
  command.add_option("--crop", o.crop, "COLUMN,ROW,WIDTH,HEIGHT in pixels")
      ->delimiter(',')
      ->expected(4);
  command.add_option("--background", o.background,
                     "its colour, #rrggbb, or a photograph of the empty rig;\n"
                     "default: the median colour of the top tenth");
  command.add_option("--threshold", o.threshold,
                     "of the contrast with the background, in units of colour difference;\n"
                     "default: by Otsu's method");
  command.add_option("--component", o.components, "NAME=#rrggbb of one component; repeat for each");
}

void add_run_options(CLI::App& command, MeasureOptions& o) {
  command.add_option("--snapshot", o.snapshot, "number from 1, or a stage; default: the last");
  command.add_option("--view", o.view, "front looks along y, side along x")
      ->check(CLI::IsMember({"front", "side"}))
      ->capture_default_str();
  command.add_option("--fastest", o.fastest_m_s, "m/s; faster grains are in flight and not seen")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--window", o.window, "LEFT,BOTTOM,RIGHT,TOP: only grains within, m")
      ->delimiter(',')
      ->expected(4);
}

void add_segregation_options(CLI::App& command, MeasureOptions& o) {
  command.add_option("--grid", o.grid, "segregation over bins instead of an angle")
      ->check(CLI::IsMember({"x", "y", "vertical", "radial", "circumferential", "cubic"}));
  command
      .add_option("--bin", o.bins,
                  "SIZE[,SIZE...] of a bin, m, or degrees of a sector; the first gives\n"
                  "the KPIs; default: ten reference diameters, or 45")
      ->delimiter(',');
  command
      .add_option("--origin", o.origin,
                  "X,Y,Z: a corner of a bin, or on the axis of rings and sectors, m")
      ->delimiter(',')
      ->expected(3);
  command.add_option("--box", o.box, "X,Y,Z,X,Y,Z: only grains between these corners, m")
      ->delimiter(',')
      ->expected(6);
  command
      .add_option("--least-fill", o.least_fill,
                  "leave out bins with less than this times the mean mass")
      ->check(CLI::Range(0.0, 1.0));
  command.add_option("--over-time", o.over_time,
                     "REGION: segregation of what passes through a region of the case");
  command.add_option("--initial", o.initial,
                     "NUMBER|STAGE: snapshot of the initial shares (--over-time; default:\n"
                     "the last one with the most mass), or for the rise of centres of\n"
                     "mass (--grid)");
  command.add_option("-o,--output", o.output, "table of bins, or of times, *.h5 or *.csv");
}

void add_bulk_options(CLI::App& command, MeasureOptions& o) {
  command.add_option("--flow", o.flow,
                     "REGION: mass flow out of a region; of a table: its column of masses");
  command
      .add_option("--flow-window", o.flow_window,
                  "FROM,TO: steady part, s of the run or table; default: found")
      ->delimiter(',')
      ->expected(2);
  command.add_option("--filter", o.filter_s, "standard deviation of the Gaussian filter, s")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_flag("--bulk-density", o.bulk_density, "mass of the grains in --box over its volume");
  command.add_flag("--contacts", o.contacts, "mean contact forces of each pair of materials");
  command.add_option("--stage", o.stage, "over which contacts are averaged; default: the last");
}

}  // namespace

void add_measure(CLI::App& app) {
  auto o = std::make_shared<MeasureOptions>();
  auto* command = add_command(
      app, "measure", "Measures a run, a photograph or a load cell by the same method",
      "repose measure heap.jpg --crop 200,150,1800,900 --scale 0.0005 --audit heap.svg\n"
      "         repose measure run --window -0.25,-0.27,0.25,0 --audit heap.svg\n"
      "         repose measure run --grid radial --bin 0.04,0.06,0.08 -o bins.csv\n"
      "         repose measure run --flow upper_box\n"
      "Places and lengths are in m for a run, in pixels of the whole picture for a photograph.\n"
      "A draw-down gives its own KPIs unless an option names an edge.",
      o->common);
  command
      ->add_option("INPUT", o->input,
                   "folder or run.h5 of a run, PNG or JPEG file, or CSV of a load cell")
      ->required();
  add_edge_options(*command, *o);
  add_photograph_options(*command, *o);
  add_run_options(*command, *o);
  add_segregation_options(*command, *o);
  add_bulk_options(*command, *o);
  command->callback([o, command] { measure(*o, *command); });
}

}  // namespace repose::cli
