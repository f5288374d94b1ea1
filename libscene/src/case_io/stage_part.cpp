// Regions, stages and output in a case file.
#include <cmath>
#include <limits>

#include "case_io/parts.hpp"

namespace repose::scene {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const char* const kAxes[3] = {"x", "y", "z"};

}  // namespace

/// A region gives only the bounds that it has: x_above_m, x_below_m, ... or lower_m and upper_m.
Region read_region(const TomlTable& table) {
  Region region;
  region.name = table.text("name");
  region.lower.setConstant(-kInfinity);
  region.upper.setConstant(kInfinity);
  if (table.has("lower_m")) region.lower = vector3(table, "lower_m");
  if (table.has("upper_m")) region.upper = vector3(table, "upper_m");
  for (int k = 0; k < 3; ++k) {
    const std::string above = std::string(kAxes[k]) + "_above_m";
    const std::string below = std::string(kAxes[k]) + "_below_m";
    if (table.has(above)) region.lower[k] = table.number(above);
    if (table.has(below)) region.upper[k] = table.number(below);
  }
  if (table.has("axis_start_m") || table.has("axis_end_m") || table.has("radius_m"))
    region.cylinder = RegionCylinder{vector3(table, "axis_start_m"), vector3(table, "axis_end_m"),
                                     table.number("radius_m", kPositive)};
  region.removes = table.flag_or("removes", region.removes);
  return region;
}

Stage read_stage(const TomlTable& table) {
  Stage stage;
  stage.name = table.text("name");
  stage.opens = texts_or_none(table, "opens");
  stage.duration_s = table.number("duration_s", kPositive);
  stage.minimum_s = table.number_or("minimum_s", 0.0, kNonNegative);
  if (const auto rest = table.table_if_present("at_rest")) {
    AtRest criterion;
    criterion.kinetic_energy_ratio =
        rest->number_or("kinetic_energy_ratio", criterion.kinetic_energy_ratio, kPositive);
    criterion.window_s = rest->number_or("window_s", criterion.window_s, kPositive);
    stage.at_rest = criterion;
  }
  if (const auto ends = table.table_if_present("flow_ends")) {
    FlowEnds criterion;
    criterion.region = ends->text("region");
    criterion.fraction = ends->number_or("fraction", criterion.fraction, kPositive);
    criterion.window_s = ends->number_or("window_s", criterion.window_s, kPositive);
    stage.flow_ends = criterion;
  }
  if (const auto all = table.table_if_present("coefficients"))
    stage.coefficients = StageCoefficients{
        .restitution = all->number("restitution", {.lower = 0.0, .upper = 1.0, .open_lower = true}),
        .mu_s = all->number("mu_s", kNonNegative),
        .mu_r = all->number("mu_r", kNonNegative)};
  return stage;
}

Output read_output(const TomlTable& table) {
  Output output;
  output.snapshot_interval_s =
      table.number_or("snapshot_interval_s", output.snapshot_interval_s, kNonNegative);
  output.series_interval_s =
      table.number_or("series_interval_s", output.series_interval_s, kPositive);
  output.vtp = table.flag_or("vtp", output.vtp);
  output.energy = table.flag_or("energy", output.energy);
  output.checkpoint_wall_time_s =
      table.number_or("checkpoint_wall_time_s", output.checkpoint_wall_time_s, kNonNegative);
  return output;
}

void write_region(CaseText& out, const Region& region) {
  out.heading("[[region]]");
  out.put("name", region.name);
  for (int k = 0; k < 3; ++k) {
    if (std::isfinite(region.lower[k]))
      out.put(std::string(kAxes[k]) + "_above_m", region.lower[k]);
    if (std::isfinite(region.upper[k]))
      out.put(std::string(kAxes[k]) + "_below_m", region.upper[k]);
  }
  if (region.cylinder) {
    out.put("axis_start_m", region.cylinder->start);
    out.put("axis_end_m", region.cylinder->end);
    out.put("radius_m", region.cylinder->radius_m);
  }
  out.put_flag("removes", region.removes);
}

void write_stage(CaseText& out, const Stage& stage) {
  out.heading("[[stage]]");
  out.put("name", stage.name);
  out.put("opens", stage.opens);
  out.put("duration_s", stage.duration_s);
  out.put("minimum_s", stage.minimum_s);
  if (stage.at_rest)
    out.raw("at_rest",
            "{kinetic_energy_ratio = " + number_text(stage.at_rest->kinetic_energy_ratio) +
                ", window_s = " + number_text(stage.at_rest->window_s) + "}");
  if (stage.flow_ends)
    out.raw("flow_ends", "{region = " + toml_quoted(stage.flow_ends->region) +
                             ", fraction = " + number_text(stage.flow_ends->fraction) +
                             ", window_s = " + number_text(stage.flow_ends->window_s) + "}");
  if (const auto& all = stage.coefficients)
    out.raw("coefficients", "{restitution = " + number_text(all->restitution) +
                                ", mu_s = " + number_text(all->mu_s) +
                                ", mu_r = " + number_text(all->mu_r) + "}");
}

void write_output(CaseText& out, const Output& output) {
  out.heading("[output]");
  out.put("snapshot_interval_s", output.snapshot_interval_s);
  out.put("series_interval_s", output.series_interval_s);
  out.put_flag("vtp", output.vtp);
  out.put_flag("energy", output.energy);
  out.put("checkpoint_wall_time_s", output.checkpoint_wall_time_s);
}

}  // namespace repose::scene
