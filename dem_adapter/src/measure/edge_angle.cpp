#include "repose/dem_adapter/edge_angle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kTheilSenPoints = 400;  // 79,800 slopes; more are thinned out evenly
constexpr double kMadToDeviation = 1.4826;    // of normally distributed errors
constexpr double kOutlierDeviations = 4.0;
constexpr int kTrimmingRounds = 50;

struct Points {
  std::vector<double> x, z;
};

Points points_of(const Profile& profile, double from, double to, double lowest, double highest) {
  Points points;
  for (std::size_t c = 0; c < profile.top_m.size(); ++c) {
    const double x = profile.x_m(c), z = profile.top_m[c];
    if (!(x >= from && x <= to && z >= lowest && z <= highest)) continue;
    points.x.push_back(x);
    points.z.push_back(z);
  }
  return points;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// Slope and intercept of least squares; `line` keeps its other members.
void least_squares(const Points& points, FittedLine& line) {
  line.points = static_cast<int>(points.x.size());
  if (points.x.size() < 2) {
    line.slope = line.intercept_m = line.rms_m = kNaN;
    return;
  }
  const auto n = static_cast<double>(points.x.size());
  double mean_x = 0.0, mean_z = 0.0, sxx = 0.0, sxz = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    mean_x += points.x[i];
    mean_z += points.z[i];
  }
  mean_x /= n;
  mean_z /= n;
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    sxx += (points.x[i] - mean_x) * (points.x[i] - mean_x);
    sxz += (points.x[i] - mean_x) * (points.z[i] - mean_z);
  }
  line.slope = sxz / sxx;
  line.intercept_m = mean_z - line.slope * mean_x;
  for (std::size_t i = 0; i < points.x.size(); ++i)
    squares += std::pow(points.z[i] - line.intercept_m - line.slope * points.x[i], 2);
  line.rms_m = std::sqrt(squares / n);
}

/// Median slope of all pairs, and the intercept that leaves as many points above as below.
void theil_sen(const Points& points, FittedLine& line) {
  const std::size_t stride = (points.x.size() + kTheilSenPoints - 1) / kTheilSenPoints;
  std::vector<double> values;
  for (std::size_t i = 0; i < points.x.size(); i += stride)
    for (std::size_t j = i + stride; j < points.x.size(); j += stride)
      values.push_back((points.z[j] - points.z[i]) / (points.x[j] - points.x[i]));
  line.slope = median(values);
  values.clear();
  for (std::size_t i = 0; i < points.x.size(); ++i)
    values.push_back(points.z[i] - line.slope * points.x[i]);
  line.intercept_m = median(values);
}

void robust(const Points& points, double column_m, FittedLine& line) {
  if (points.x.size() < 3) return least_squares(points, line);
  theil_sen(points, line);
  Points used;
  for (int round = 0; round < kTrimmingRounds; ++round) {
    std::vector<double> distance(points.x.size());
    for (std::size_t i = 0; i < distance.size(); ++i)
      distance[i] = std::abs(points.z[i] - line.intercept_m - line.slope * points.x[i]);
    const double limit =
        std::max(kOutlierDeviations * kMadToDeviation * median(distance), 0.5 * column_m);
    Points kept;
    for (std::size_t i = 0; i < distance.size(); ++i) {
      if (distance[i] > limit) continue;
      kept.x.push_back(points.x[i]);
      kept.z.push_back(points.z[i]);
    }
    if (kept.x == used.x) break;
    used = std::move(kept);
    least_squares(used, line);
  }
  line.outliers = static_cast<int>(points.x.size()) - line.points;
}

/// Degrees, positive if the line rises in the direction of `sign`.
double signed_angle_deg(const FittedLine& line, double sign) {
  return sign * line.slope < 0.0 ? -line.angle_deg() : line.angle_deg();
}

/// Distance from the axis at which a half of the heap ends. `side` is -1 or 1.
double heap_end_m(const Profile& heap, const HeapOptions& options, double side) {
  const auto n = static_cast<double>(heap.top_m.size());
  for (double d = 0.5 * heap.column_m; d < options.reach_m; d += heap.column_m) {
    const double column = std::round((options.axis_m + side * d - heap.first_x_m) / heap.column_m);
    if (column < 0.0 || column >= n) return std::min(d, options.reach_m);
    const double top = heap.top_m[static_cast<std::size_t>(column)];
    if (std::isnan(top) || top - options.floor_m < options.toe_m) return d;
  }
  return options.reach_m;
}

}  // namespace

double FittedLine::angle_deg() const {
  return std::atan(std::abs(slope)) * 180.0 / std::numbers::pi;
}

FittedLine fit_line(const Profile& profile, double from_m, double to_m, LineFit fit,
                    double lowest_m, double highest_m) {
  const Points points = points_of(profile, from_m, to_m, lowest_m, highest_m);
  FittedLine line{.from_m = from_m, .to_m = to_m};
  if (fit == LineFit::least_squares)
    least_squares(points, line);
  else
    robust(points, profile.column_m, line);
  return line;
}

HeapAngles heap_angles(const Profile& profile, const HeapOptions& options) {
  REPOSE_ASSERT(options.from >= 0.0 && options.from < options.to && options.to <= 1.0,
                fmt::format("{} {}", options.from, options.to));
  HeapAngles heap;
  heap.left_end_m = heap_end_m(profile, options, -1.0);
  heap.right_end_m = heap_end_m(profile, options, 1.0);
  const double left = options.axis_m - heap.left_end_m, right = options.axis_m + heap.right_end_m;
  for (std::size_t c = 0; c < profile.top_m.size(); ++c)
    if (profile.x_m(c) >= left && profile.x_m(c) <= right && !std::isnan(profile.top_m[c]))
      heap.height_m = std::max(heap.height_m, profile.top_m[c] - options.floor_m);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const double lowest = options.from > 0.0 ? options.floor_m + options.from * heap.height_m : -kFar;
  const double highest = options.to < 1.0 ? options.floor_m + options.to * heap.height_m : kFar;
  heap.left = fit_line(profile, left, options.axis_m, options.fit, lowest, highest);
  heap.right = fit_line(profile, options.axis_m, right, options.fit, lowest, highest);
  heap.left_deg = signed_angle_deg(heap.left, 1.0);
  heap.right_deg = signed_angle_deg(heap.right, -1.0);
  return heap;
}

double heap_axis_m(const Profile& profile, double floor_m, double toe_m) {
  std::size_t peak = profile.top_m.size();
  for (std::size_t c = 0; c < profile.top_m.size(); ++c)
    if (!std::isnan(profile.top_m[c]) &&
        (peak == profile.top_m.size() || profile.top_m[c] > profile.top_m[peak]))
      peak = c;
  if (peak == profile.top_m.size()) return kNaN;
  const auto is_heap = [&](std::size_t c) { return profile.top_m[c] - floor_m >= toe_m; };
  std::size_t first = peak, last = peak;
  while (first > 0 && is_heap(first - 1)) --first;
  while (last + 1 < profile.top_m.size() && is_heap(last + 1)) ++last;
  return 0.5 * (profile.x_m(first) + profile.x_m(last));
}

EdgeAngles slope_angles(const Profile& profile, double lower_m, double outlet_left_m,
                        double outlet_right_m, double upper_m, LineFit fit) {
  EdgeAngles slopes;
  slopes.left = fit_line(profile, lower_m, outlet_left_m, fit);
  slopes.right = fit_line(profile, outlet_right_m, upper_m, fit);
  slopes.left_deg = signed_angle_deg(slopes.left, -1.0);
  slopes.right_deg = signed_angle_deg(slopes.right, 1.0);
  return slopes;
}

}  // namespace repose::dem_adapter
