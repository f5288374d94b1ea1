// repose measure: KPIs of a run, a photograph or a load cell, by the same code.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "measurement_text.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/drawdown.hpp"
#include "repose/dem_adapter/picture.hpp"
#include "repose/dem_adapter/run_bulk.hpp"
#include "repose/dem_adapter/run_segregation.hpp"
#include "repose/dem_adapter/view.hpp"
#include "repose/dem_adapter/view_angle.hpp"
#include "repose/scene/run_output.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

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
  std::vector<int> crop;
  std::string background;
  std::vector<std::string> components;
  // runs
  std::string snapshot, view = "front";
  std::vector<double> window;
  // segregation
  std::vector<int> slices;
  std::string grid, over_time, output;
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

dem_adapter::EdgeOptions edge_options(const MeasureOptions& o) {
  dem_adapter::EdgeOptions edge{
      .shape = o.shape == "heap" ? dem_adapter::EdgeShape::heap : dem_adapter::EdgeShape::slopes,
      .axis_m = o.axis,
      .floor_m = o.floor,
      .toe_m = o.toe,
      .from = o.from,
      .to = o.to,
      .fit =
          o.fit == "robust" ? dem_adapter::LineFit::robust : dem_adapter::LineFit::least_squares};
  if (!o.outlet.empty()) edge.outlet_m = {o.outlet[0], o.outlet[1]};
  return edge;
}

/// The same in the unit of a photograph's view: rows count downwards, z upwards.
dem_adapter::EdgeOptions edge_options_of_photograph(const MeasureOptions& o) {
  auto edge = edge_options(o);
  const double scale = o.scale.value_or(1.0);
  if (edge.axis_m) *edge.axis_m *= scale;
  if (edge.floor_m) *edge.floor_m *= -scale;
  if (edge.toe_m) *edge.toe_m *= scale;
  if (edge.outlet_m) edge.outlet_m = {o.outlet[0] * scale, o.outlet[1] * scale};
  return edge;
}

dem_adapter::Segmentation segmentation_of(const MeasureOptions& o,
                                          const dem_adapter::PixelBox& crop) {
  dem_adapter::Segmentation segmentation{.threshold = o.threshold};
  if (o.background.starts_with('#'))
    segmentation.background = dem_adapter::parse_color(o.background);
  else if (!o.background.empty())
    segmentation.background = cropped(dem_adapter::read_picture(o.background), crop);
  for (const auto& component : o.components) {
    const auto equals = component.find('=');
    if (equals == std::string::npos || equals == 0)
      throw UsageError(
          fmt::format("--component {}: write NAME=COLOUR, e.g. pellet=#705040", component));
    segmentation.components.push_back(
        {.name = component.substr(0, equals),
         .color = dem_adapter::parse_color(component.substr(equals + 1))});
  }
  return segmentation;
}

dem_adapter::View photograph_view(const MeasureOptions& o) {
  const auto picture = dem_adapter::read_picture(o.input);
  dem_adapter::PixelBox crop{.width = picture.width, .height = picture.height};
  if (!o.crop.empty()) crop = {o.crop[0], o.crop[1], o.crop[2], o.crop[3]};
  const auto part = cropped(picture, crop);
  return dem_adapter::view_of_photograph(part, segmentation_of(o, crop), o.scale, crop.column,
                                         crop.row);
}

dem_adapter::Measurement measured_view(const MeasureOptions& o, const dem_adapter::View& view,
                                       const dem_adapter::EdgeOptions& edge) {
  const auto angle = measure_angle(view, edge);
  auto m = angle.measurement;
  if (!o.slices.empty()) {
    auto slices = dem_adapter::measure_slices(view, o.slices[0], o.slices[1]);
    m.kpis.merge(slices.kpis);
    m.details.merge(slices.details);
  }
  if (!o.audit.empty()) write_file_atomically(o.audit, audit_svg(view, angle, o.input));
  return m;
}

Measured measure_photograph(const MeasureOptions& o) {
  return {.measurement = measured_view(o, photograph_view(o), edge_options_of_photograph(o))};
}

/// What may be measured of a run beside an edge, with the options that belong to it.
struct Subject {
  const char* option;
  std::vector<const char*> own;
};
const std::vector<Subject>& subjects() {
  static const std::vector<Subject> kSubjects{
      {"--grid", {"--bin", "--origin", "--least-fill", "--box", "--snapshot", "--output"}},
      {"--over-time", {"--output"}},
      {"--flow", {"--flow-window", "--filter"}},
      {"--bulk-density", {"--box", "--snapshot"}},
      {"--contacts", {"--stage"}}};
  return kSubjects;
}
/// Of the edge and the view, without which a draw-down is measured as its scenario says.
constexpr std::initializer_list<const char*> kEdge{
    "--audit", "--shape", "--axis", "--floor",  "--toe",    "--outlet",  "--from",
    "--to",    "--fit",   "--view", "--slices", "--window", "--snapshot"};

/// Throws InputError unless the options given belong to one subject; nullptr: an edge.
const Subject* subject_of(const CLI::App& command) {
  const Subject* chosen = nullptr;
  for (const Subject& subject : subjects()) {
    if (command.count(subject.option) == 0) continue;
    if (chosen != nullptr)
      throw InputError(fmt::format("{} and {} measure different things; give one of them",
                                   chosen->option, subject.option));
    chosen = &subject;
  }
  const auto belongs = [&](const char* option) {
    if (chosen == nullptr)
      return std::any_of(kEdge.begin(), kEdge.end(),
                         [&](const char* own) { return std::string(own) == option; });
    return std::any_of(chosen->own.begin(), chosen->own.end(),
                       [&](const char* own) { return std::string(own) == option; });
  };
  const auto refuse = [&](const char* option) {
    if (command.count(option) > 0 && !belongs(option))
      throw InputError(fmt::format(
          "{} has no meaning {}; leave it out", option,
          chosen == nullptr ? std::string("for an edge") : std::string("with ") + chosen->option));
  };
  for (const Subject& subject : subjects())
    std::for_each(subject.own.begin(), subject.own.end(), refuse);
  std::for_each(kEdge.begin(), kEdge.end(), refuse);
  return chosen;
}

/// The last snapshot, that of a number from 1, or the last of a stage.
scene::Snapshot snapshot_of(const scene::Run& run, const std::string& wanted) {
  const std::size_t count = run.snapshots().size();
  if (count == 0) throw InputError("the run has no snapshots");
  if (wanted.empty()) return run.snapshot(count - 1);
  if (wanted.find_first_not_of("0123456789") != std::string::npos) return run.end_of(wanted);
  const auto number = wanted.size() < 10 ? std::stoul(wanted) : 0UL;
  if (number < 1 || number > count)
    throw InputError(fmt::format("--snapshot {}: the run has snapshots 1 to {}", wanted, count));
  return run.snapshot(number - 1);
}

dem_adapter::View run_view(const MeasureOptions& o, const scene::Run& run) {
  dem_adapter::ParticleViewOptions options{.direction = o.view == "front"
                                                            ? dem_adapter::ViewDirection::along_y
                                                            : dem_adapter::ViewDirection::along_x};
  if (!o.window.empty()) {
    options.left_m = o.window[0];
    options.bottom_m = o.window[1];
    options.right_m = o.window[2];
    options.top_m = o.window[3];
  }
  return view_of_particles(snapshot_of(run, o.snapshot), options);
}

scene::Region box_of(const std::vector<double>& ends) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  scene::Region box{.name = "box", .lower = {-kFar, -kFar, -kFar}, .upper = {kFar, kFar, kFar}};
  if (ends.empty()) return box;
  box.lower = {ends[0], ends[1], ends[2]};
  box.upper = {ends[3], ends[4], ends[5]};
  if (!(box.lower.array() < box.upper.array()).all())
    throw InputError("--box: each lower end must be below its upper end");
  return box;
}

void write_output(const MeasureOptions& o, table::Table table) {
  if (o.output.empty()) return;
  table::stamp_provenance(table, command_line(), {}, {o.input});
  table::write_table(table::parse_location(o.output), table);
}

Measured measured_grid(const MeasureOptions& o, const scene::Run& run) {
  const auto mixture =
      dem_adapter::mixture_of(snapshot_of(run, o.snapshot), run.scene(), box_of(o.box));
  dem_adapter::GridOptions options{
      .kind = dem_adapter::grid_kind(o.grid), .sizes = o.bins, .least_fill = o.least_fill};
  if (!o.origin.empty()) options.origin = scene::Vec3{o.origin[0], o.origin[1], o.origin[2]};
  auto result = dem_adapter::measure_segregation(mixture, options);
  write_output(o, result.bins);
  return {.measurement = result.measurement, .sizes = result.sizes};
}

Measured measured_over_time(const MeasureOptions& o, const scene::Run& run) {
  const auto result = dem_adapter::measure_discharge_segregation(run, o.over_time);
  write_output(o, result.series);
  return {.measurement = result.measurement};
}

dem_adapter::FlowOptions flow_options(const MeasureOptions& o) {
  dem_adapter::FlowOptions options{.filter_s = o.filter_s};
  if (!o.flow_window.empty())
    options.window = dem_adapter::TimeWindow{o.flow_window[0], o.flow_window[1]};
  return options;
}

Measured measured_edge(const MeasureOptions& o, const scene::Run& run, const CLI::App& command) {
  const bool names_an_edge = std::any_of(
      kEdge.begin(), kEdge.end(), [&](const char* option) { return command.count(option) > 0; });
  if (!names_an_edge && dem_adapter::Drawdown::is_of(run.scene()))
    return {.measurement = dem_adapter::Drawdown{}.measure(run)};
  return {.measurement = measured_view(o, run_view(o, run), edge_options(o))};
}

Measured measure_run(const MeasureOptions& o, const CLI::App& command) {
  const Subject* subject = subject_of(command);
  if (o.bulk_density && o.box.empty())
    throw InputError("--bulk-density needs --box X,Y,Z,X,Y,Z, a box inside the bed");
  std::filesystem::path folder = o.input;
  if (std::filesystem::exists(folder / "output")) folder /= "output";
  const auto run = scene::read_run(folder);
  const std::string option = subject == nullptr ? "" : subject->option;
  if (option == "--grid") return measured_grid(o, run);
  if (option == "--over-time") return measured_over_time(o, run);
  if (option == "--flow")
    return {.measurement = dem_adapter::measure_flow(dem_adapter::discharge_curve(run, o.flow),
                                                     flow_options(o))};
  if (option == "--bulk-density")
    return {.measurement = dem_adapter::measure_bulk_density(snapshot_of(run, o.snapshot),
                                                             run.scene(), box_of(o.box))};
  if (option == "--contacts")
    return {.measurement = dem_adapter::measure_contacts(
                run, o.stage.empty() ? std::nullopt : std::optional(o.stage))};
  return measured_edge(o, run, command);
}

Measured measure_mass_table(const MeasureOptions& o) {
  const auto table = table::read_table(table::parse_location(o.input));
  return {
      .measurement = dem_adapter::measure_flow(
          {.time_s = table.numbers("time_s"), .mass_kg = table.numbers(o.flow)}, flow_options(o))};
}

constexpr std::initializer_list<const char*> kPhotographOnly{"--scale", "--threshold", "--crop",
                                                             "--background", "--component"};
constexpr std::initializer_list<const char*> kSnapshotOnly{
    "--snapshot",     "--view",       "--window", "--grid",   "--bin",
    "--origin",       "--least-fill", "--box",    "--output", "--over-time",
    "--bulk-density", "--contacts",   "--stage"};
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
  command.add_option("--shape", o.shape, "what the edge is: a heap, or the slopes at an outlet")
      ->check(CLI::IsMember({"heap", "slopes"}))
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
