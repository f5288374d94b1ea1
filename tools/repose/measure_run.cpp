// repose measure RUN: one subject at a time, an edge, segregation, flow, density or contacts.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "measure_options.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/drawdown.hpp"
#include "repose/dem_adapter/run_bulk.hpp"
#include "repose/dem_adapter/run_segregation.hpp"
#include "repose/scene/run_output.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

/// What may be measured of a run beside an edge, with the options that belong to it.
struct Subject {
  const char* option;
  std::vector<const char*> own;
};
const std::vector<Subject>& subjects() {
  static const std::vector<Subject> kSubjects{
      {"--grid",
       {"--bin", "--origin", "--least-fill", "--box", "--snapshot", "--initial", "--output"}},
      {"--over-time", {"--output", "--initial"}},
      {"--flow", {"--flow-window", "--filter"}},
      {"--bulk-density", {"--box", "--snapshot"}},
      {"--contacts", {"--stage"}}};
  return kSubjects;
}
/// Of the edge and the view, without which a draw-down is measured as its scenario says.
constexpr std::initializer_list<const char*> kEdge{
    "--audit", "--shape", "--axis",   "--floor",  "--toe",      "--outlet", "--from",   "--to",
    "--fit",   "--view",  "--slices", "--window", "--snapshot", "--box",    "--fastest"};

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

/// Index of a snapshot: a number from 1, or a stage for the last one of it.
std::size_t snapshot_index(const scene::Run& run, const std::string& option,
                           const std::string& wanted) {
  const auto& snapshots = run.snapshots();
  if (wanted.find_first_not_of("0123456789") == std::string::npos) {
    const auto number = wanted.size() < 10 ? std::stoul(wanted) : 0UL;
    if (number < 1 || number > snapshots.size())
      throw InputError(
          fmt::format("{} {}: the run has snapshots 1 to {}", option, wanted, snapshots.size()));
    return number - 1;
  }
  std::vector<std::string> stages;
  for (std::size_t i = snapshots.size(); i-- > 0;) {
    if (snapshots[i].stage == wanted) return i;
    if (stages.empty() || stages.back() != snapshots[i].stage) stages.push_back(snapshots[i].stage);
  }
  throw InputError(fmt::format("{} {}: no such stage; there are snapshots of {}", option, wanted,
                               listed(stages)));
}

/// The one asked for by --snapshot, by default the last.
scene::Snapshot snapshot_of(const scene::Run& run, const std::string& wanted) {
  if (run.snapshots().empty()) throw InputError("the run has no snapshots");
  return run.snapshot(wanted.empty() ? run.snapshots().size() - 1
                                     : snapshot_index(run, "--snapshot", wanted));
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

dem_adapter::View run_view(const MeasureOptions& o, const scene::Run& run) {
  dem_adapter::ParticleViewOptions options{.direction = o.view == "front"
                                                            ? dem_adapter::ViewDirection::along_y
                                                            : dem_adapter::ViewDirection::along_x};
  options.fastest_m_s = o.fastest_m_s;
  if (!o.box.empty()) options.region = box_of(o.box);
  if (!o.window.empty()) {
    options.left_m = o.window[0];
    options.bottom_m = o.window[1];
    options.right_m = o.window[2];
    options.top_m = o.window[3];
  }
  return view_of_particles(snapshot_of(run, o.snapshot), options);
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
  if (!o.initial.empty()) {
    const auto initial = run.snapshot(snapshot_index(run, "--initial", o.initial));
    for (const auto& [name, shift] : dem_adapter::center_of_mass_shifts(
             dem_adapter::mixture_of(initial, run.scene(), box_of(o.box)), mixture))
      result.measurement.details["center_of_mass_shift_" + name] = shift;
  }
  write_output(o, result.bins);
  return {.measurement = result.measurement, .sizes = result.sizes};
}

Measured measured_over_time(const MeasureOptions& o, const scene::Run& run) {
  dem_adapter::DischargeOptions options;
  if (!o.initial.empty()) options.initial_snapshot = snapshot_index(run, "--initial", o.initial);
  const auto result = dem_adapter::measure_discharge_segregation(run, o.over_time, options);
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

}  // namespace

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

}  // namespace repose::cli
