#include "repose/scene/grains.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace repose::scene {
namespace {

constexpr int kClasses = 64;

/// Mass finer than d, before the cut-offs.
double finer(const LogNormal& sizes, double d) {
  const double z = std::log(d / sizes.median_diameter_m) / std::log(sizes.geometric_sd);
  return 0.5 * std::erfc(-z / std::sqrt(2.0));
}
double finer(const RosinRammler& sizes, double d) {
  return -std::expm1(-std::pow(d / sizes.scale_diameter_m, sizes.spread));
}

template <class Distribution>
std::vector<SizeClass> classes_of(const Distribution& sizes) {
  const double ratio = sizes.upper_diameter_m / sizes.lower_diameter_m;
  const auto bound = [&](int k) {
    if (k == kClasses) return sizes.upper_diameter_m;
    return sizes.lower_diameter_m * std::pow(ratio, static_cast<double>(k) / kClasses);
  };
  const double below = finer(sizes, sizes.lower_diameter_m);
  const double kept = finer(sizes, sizes.upper_diameter_m) - below;
  std::vector<SizeClass> classes;
  for (int k = 0; k < kClasses; ++k)
    classes.push_back(
        {bound(k), bound(k + 1), (finer(sizes, bound(k + 1)) - finer(sizes, bound(k))) / kept});
  return classes;
}

}  // namespace

std::vector<SizeClass> size_classes(const Sizes& sizes) {
  if (const auto* classes = std::get_if<std::vector<SizeClass>>(&sizes)) return *classes;
  if (const auto* log_normal = std::get_if<LogNormal>(&sizes)) return classes_of(*log_normal);
  return classes_of(std::get<RosinRammler>(sizes));
}

double mass_between_cut_offs(const Sizes& sizes) {
  const auto between = [](const auto& distribution) {
    return finer(distribution, distribution.upper_diameter_m) -
           finer(distribution, distribution.lower_diameter_m);
  };
  if (const auto* log_normal = std::get_if<LogNormal>(&sizes)) return between(*log_normal);
  if (const auto* rosin = std::get_if<RosinRammler>(&sizes)) return between(*rosin);
  return 1.0;
}

double largest_diameter_m(const Sizes& sizes) {
  if (const auto* log_normal = std::get_if<LogNormal>(&sizes)) return log_normal->upper_diameter_m;
  if (const auto* rosin = std::get_if<RosinRammler>(&sizes)) return rosin->upper_diameter_m;
  double largest = 0.0;
  for (const SizeClass& size : std::get<std::vector<SizeClass>>(sizes))
    largest = std::max(largest, size.upper_diameter_m);
  return largest;
}

double smallest_diameter_m(const Sizes& sizes) {
  if (const auto* log_normal = std::get_if<LogNormal>(&sizes)) return log_normal->lower_diameter_m;
  if (const auto* rosin = std::get_if<RosinRammler>(&sizes)) return rosin->lower_diameter_m;
  double smallest = 0.0;
  for (const SizeClass& size : std::get<std::vector<SizeClass>>(sizes))
    if (smallest == 0.0 || size.lower_diameter_m < smallest) smallest = size.lower_diameter_m;
  return smallest;
}

const std::vector<ClumpShape>& shipped_clumps() {
  // Three equal spheres on an equilateral triangle with sides of 1.75 radii: their volume is that
  // of three spheres less three lenses of pi (4 + s)(2 - s)^2/12, s = 1.75, so that a sphere has
  // 0.699 of the volume-equivalent radius.
  static const std::vector<ClumpShape> kShapes{
      {"sinter_3",
       {{{0.0, 0.0, 0.0}, 1.0},
        {{1.75, 0.0, 0.0}, 1.0},
        {{0.875, 0.875 * std::numbers::sqrt3, 0.0}, 1.0}}}};
  return kShapes;
}

}  // namespace repose::scene
