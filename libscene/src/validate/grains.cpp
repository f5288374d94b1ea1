// Clumps, sizes and mixtures.
#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/clump_form.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

/// The least mass between cut-offs with which a distribution makes sense.
constexpr double kLeastKept = 1e-6;

/// Checks sizes; `what` begins the messages.
struct SizesCheck {
  const std::string& what;

  void operator()(const std::vector<SizeClass>& classes) const {
    if (classes.empty())
      throw InputError(what + "has no sizes; add sizes = [{diameter_m = ..., mass_fraction = 1}]");
    double sum = 0.0;
    for (const SizeClass& size : classes) {
      require_positive(what + "lower_diameter_m", size.lower_diameter_m);
      require_positive(what + "upper_diameter_m", size.upper_diameter_m);
      require_positive(what + "mass_fraction", size.mass_fraction);
      if (size.upper_diameter_m < size.lower_diameter_m)
        refuse(what + "upper_diameter_m", size.upper_diameter_m,
               "must be at least lower_diameter_m = " + shortest(size.lower_diameter_m));
      sum += size.mass_fraction;
    }
    if (std::abs(sum - 1.0) > 1e-9)
      refuse(what + "sum of mass_fraction", sum, "the sizes must sum to 1");
  }
  void operator()(const LogNormal& sizes) const {
    require_positive(what + "median_diameter_m", sizes.median_diameter_m);
    if (!(sizes.geometric_sd > 1.0) || !std::isfinite(sizes.geometric_sd))
      refuse(what + "geometric_sd", sizes.geometric_sd,
             "must be above 1: the diameter varies by this factor; use a class for one size");
    check_cut_offs(sizes);
  }
  void operator()(const RosinRammler& sizes) const {
    require_positive(what + "scale_diameter_m", sizes.scale_diameter_m);
    require_positive(what + "spread", sizes.spread);
    check_cut_offs(sizes);
  }

  template <class Distribution>
  void check_cut_offs(const Distribution& sizes) const {
    require_positive(what + "lower_diameter_m", sizes.lower_diameter_m);
    require_positive(what + "upper_diameter_m", sizes.upper_diameter_m);
    if (!(sizes.upper_diameter_m > sizes.lower_diameter_m))
      refuse(what + "upper_diameter_m", sizes.upper_diameter_m,
             "must be above lower_diameter_m = " + shortest(sizes.lower_diameter_m));
    const double kept = mass_between_cut_offs(sizes);
    if (!(kept >= kLeastKept))
      throw InputError(what + "only " + shortest(kept) + " of the mass lies between " +
                       shortest(sizes.lower_diameter_m) + " and " +
                       shortest(sizes.upper_diameter_m) +
                       " m; move the cut-offs to where the distribution has its mass");
  }
};

std::vector<std::string> names_of(const std::vector<ClumpShape>& clumps) {
  std::vector<std::string> names;
  for (const ClumpShape& clump : clumps) names.push_back(clump.name);
  return names;
}

}  // namespace

void check_clumps(const Case& scene) {
  std::vector<std::string> names = names_of(shipped_clumps());
  const std::vector<std::string> own = names_of(scene.clumps);
  names.insert(names.end(), own.begin(), own.end());
  require_unique("clump", names);
  for (const ClumpShape& clump : scene.clumps) clump_form(clump);
}

void require_clump(const Case& scene, const std::string& what, const std::string& name) {
  if (name.empty()) return;
  try {
    clump_shape(scene, name);
  } catch (const InputError& error) {
    throw InputError(what + error.what());
  }
}

double bounding_ratio(const Case& scene, const std::string& clump) {
  return clump.empty() ? 1.0 : clump_form(clump_shape(scene, clump)).bounding_radius;
}

double largest_bounding_diameter_m(const Case& scene, const std::vector<Grains>& mixture) {
  double largest = 0.0;
  for (const Grains& kind : mixture)
    largest = std::max(largest, largest_diameter_m(kind.sizes) * bounding_ratio(scene, kind.clump));
  return largest;
}

void check_diameter_in_periods(const Case& scene, const std::string& what, double diameter_m) {
  for (int k = 0; k < 3; ++k) {
    const double length = scene.upper_m[k] - scene.lower_m[k];
    if (is_periodic(scene, k) && length < 2.0 * diameter_m)
      refuse(what + "diameter_m", diameter_m,
             std::string("the period ") + shortest(length) + " m of direction " + kAxes[k] +
                 " must be at least two of the largest diameters");
  }
}

void check_mixture(const Case& scene, const std::string& what, const std::vector<Grains>& mixture) {
  if (mixture.empty()) throw InputError(what + "has no particles; give material and sizes");
  double sum = 0.0;
  for (const Grains& kind : mixture) {
    material_index(scene, kind.material);
    require_clump(scene, what, kind.clump);
    require_non_negative(what + "mass_fraction of " + kind.material, kind.mass_fraction);
    std::visit(SizesCheck{what}, kind.sizes);
    sum += kind.mass_fraction;
  }
  if (std::abs(sum - 1.0) > 1e-9)
    refuse(what + "sum of mass_fraction of the mixture", sum, "the kinds must sum to 1");
  check_diameter_in_periods(scene, what, largest_bounding_diameter_m(scene, mixture));
}

}  // namespace repose::scene
