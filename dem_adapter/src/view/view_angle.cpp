#include "repose/dem_adapter/view_angle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

constexpr int kLeastColumns = 10;
constexpr double kToeOfHeight = 0.02;

double right_m(const View& view) {
  return view.left_m + view.picture.width * view.pixel_m;
}

/// z of the lower edge of the lowest pixel with a label.
double lowest_m(const View& view) {
  for (int row = view.picture.height; row-- > 0;)
    for (int column = 0; column < view.picture.width; ++column)
      if (view.label[view.picture.index(column, row)] != kBackground)
        return view.bottom_m + (view.picture.height - row - 1) * view.pixel_m;
  throw InputError("nothing but background is in the picture");
}

double highest_m(const Profile& profile) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const double top : profile.top_m)
    if (!std::isnan(top)) highest = std::max(highest, top);
  return highest;
}

void check_within(const View& view, const char* name, double x) {
  if (!(x >= view.left_m && x <= right_m(view)))
    throw InputError(
        fmt::format("{} = {:.6g} {} lies outside the view, which reaches from {:.6g} "
                    "to {:.6g}",
                    name, x, view.unit, view.left_m, right_m(view)));
}

/// A floor may lie below what is seen, though not farther than that is high.
void check_floor(const View& view, double floor) {
  const double height = view.picture.height * view.pixel_m, top = view.bottom_m + height;
  if (!(floor >= view.bottom_m - height && floor <= top))
    throw InputError(fmt::format(
        "floor: z = {:.6g} {} lies outside the view, which reaches from {:.6g} to {:.6g} (z of a "
        "photograph is minus its row)",
        floor, view.unit, view.bottom_m, top));
}

/// Throws InputError if an option is given that its shape does not have.
void check_shape(const EdgeOptions& options) {
  const char* shape = options.shape == EdgeShape::heap     ? "a heap"
                      : options.shape == EdgeShape::slopes ? "slopes"
                                                           : "a surface";
  const auto refuse = [&](const char* option, bool is_given) {
    if (is_given)
      throw InputError(fmt::format("{} has no meaning for {}; leave it out", option, shape));
  };
  if (options.shape != EdgeShape::slopes) refuse("outlet", options.outlet_m.has_value());
  if (options.shape == EdgeShape::heap) return;
  refuse("axis", options.axis_m.has_value());
  refuse("toe", options.toe_m.has_value());
  refuse("a part of the height (from, to)", options.from > 0.0 || options.to < 1.0);
}

void check_sides(const EdgeAngles& angles) {
  const auto check = [](const char* side, const FittedLine& line) {
    if (line.points < kLeastColumns)
      throw InputError(fmt::format(
          "the edge has {} usable columns on the {}, at least {} are needed; check crop, axis, "
          "floor, toe and threshold, or take a larger picture",
          line.points, side, kLeastColumns));
  };
  check("left", angles.left);
  check("right", angles.right);
}

void measure_heap(const View& view, const EdgeOptions& options, ViewAngle& result) {
  const double height = highest_m(view.profile) - result.floor_m;
  const double toe = options.toe_m.value_or(view.largest_grain_m > 0.0 ? view.largest_grain_m
                                                                       : kToeOfHeight * height);
  if (!(toe >= 0.0 && toe < height))
    throw InputError(
        fmt::format("toe = {:.6g} {}: it must be from 0 to the height of the edge "
                    "above the floor, {:.6g} {}",
                    toe, view.unit, height, view.unit));
  const double axis = options.axis_m.value_or(heap_axis_m(view.profile, result.floor_m, toe));
  check_within(view, "axis", axis);
  const auto heap = heap_angles(view.profile, {.axis_m = axis,
                                               .floor_m = result.floor_m,
                                               .toe_m = toe,
                                               .from = options.from,
                                               .to = options.to,
                                               .fit = options.fit});
  check_sides(heap);
  result.angles = heap;
  auto& m = result.measurement;
  m.details["heap_height_" + view.unit] = heap.height_m;
  m.details["heap_half_base_" + view.unit] = 0.5 * (heap.left_end_m + heap.right_end_m);
  const double rim = 1.5 * view.pixel_m;
  if (axis - heap.left_end_m < view.left_m + rim || axis + heap.right_end_m > right_m(view) - rim)
    m.warnings.push_back(
        "the heap reaches a side of the view: a wall raises its angle by 1-2 degrees, and its axis "
        "is right only if it was given");
}

void measure_slopes(const View& view, const EdgeOptions& options, ViewAngle& result) {
  if (!options.outlet_m)
    throw InputError("slopes need the left and the right end of the outlet between them");
  const auto [from, to] = *options.outlet_m;
  check_within(view, "left end of the outlet", from);
  check_within(view, "right end of the outlet", to);
  if (!(from < to))
    throw InputError(fmt::format(
        "the outlet from {:.6g} to {:.6g} {}: its left end must lie left of its right end", from,
        to, view.unit));
  result.angles = slope_angles(view.profile, view.left_m, from, to, right_m(view), options.fit);
  check_sides(result.angles);
}

void measure_surface(const View& view, const EdgeOptions& options, ViewAngle& result) {
  const FittedLine line = fit_line(view.profile, view.left_m, right_m(view), options.fit);
  if (line.points < kLeastColumns)
    throw InputError(fmt::format("the surface has {} usable columns, at least {} are needed",
                                 line.points, kLeastColumns));
  result.angles = {
      .left = line, .right = line, .left_deg = line.angle_deg(), .right_deg = line.angle_deg()};
}

/// The KPI without its unit.
std::string name_of(EdgeShape shape) {
  switch (shape) {
    case EdgeShape::heap:
      return "angle_of_repose";
    case EdgeShape::slopes:
      return "shear_angle";
    case EdgeShape::surface:
      return "surface_angle";
  }
  throw InputError("the shape of the edge is not known");
}

void add_line(const std::string& prefix, const FittedLine& line, const View& view, Measurement& m) {
  m.details[prefix + "columns"] = line.points;
  m.details[prefix + "outliers"] = line.outliers;
  m.details[prefix + "rms_" + view.unit] = line.rms_m;
}

}  // namespace

ViewAngle measure_angle(const View& view, const EdgeOptions& options) {
  if (!(options.from >= 0.0 && options.from < options.to && options.to <= 1.0))
    throw InputError(
        fmt::format("the part of the height used, {} to {}, must be increasing within 0 to 1",
                    options.from, options.to));
  check_shape(options);
  ViewAngle result;
  if (options.floor_m) check_floor(view, *options.floor_m);
  result.floor_m = options.floor_m.value_or(lowest_m(view));
  if (options.shape == EdgeShape::heap)
    measure_heap(view, options, result);
  else if (options.shape == EdgeShape::slopes)
    measure_slopes(view, options, result);
  else
    measure_surface(view, options, result);
  auto& m = result.measurement;
  const std::string name = name_of(options.shape);
  m.kpis[name + "_deg"] = result.angles.mean_deg();
  if (options.shape == EdgeShape::surface) {
    add_line("edge_", result.angles.left, view, m);
  } else {
    m.details[name + "_left_deg"] = result.angles.left_deg;
    m.details[name + "_right_deg"] = result.angles.right_deg;
    add_line("edge_left_", result.angles.left, view, m);
    add_line("edge_right_", result.angles.right, view, m);
  }
  m.warnings.insert(m.warnings.begin(), view.warnings.begin(), view.warnings.end());
  return result;
}

}  // namespace repose::dem_adapter
