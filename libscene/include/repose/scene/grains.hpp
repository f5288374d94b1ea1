// What the particles are: material, shape and sizes.
#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

namespace repose::scene {

using Vec3 = Eigen::Vector3d;

/// A size class; equal bounds are one size. Within it mass is spread uniformly over the diameter.
struct SizeClass {
  double lower_diameter_m = 0.0;
  double upper_diameter_m = 0.0;
  double mass_fraction = 1.0;
  bool operator==(const SizeClass&) const = default;
};

/// Mass is log-normal in the diameter between the cut-offs: ln d has the mean ln(median) and the
/// standard deviation ln(geometric_sd).
struct LogNormal {
  double median_diameter_m = 0.0;
  double geometric_sd = 1.0;  ///< above 1; 1.5 means 68 % of mass within median/1.5 and median*1.5
  double lower_diameter_m = 0.0;
  double upper_diameter_m = 0.0;
  bool operator==(const LogNormal&) const = default;
};

/// Mass below d is 1 - exp(-(d/scale)^spread), between the cut-offs [RosinRammler1933].
struct RosinRammler {
  double scale_diameter_m = 0.0;  ///< 63.2 % of the mass is finer
  double spread = 1.0;            ///< larger is narrower
  double lower_diameter_m = 0.0;
  double upper_diameter_m = 0.0;
  bool operator==(const RosinRammler&) const = default;
};

/// Mass over the diameter. For clumps the diameter is that of a sphere of the same volume.
using Sizes = std::variant<std::vector<SizeClass>, LogNormal, RosinRammler>;

/// Any sizes as classes whose mass fractions sum to 1: a continuous distribution becomes 64 classes
/// between its cut-offs, equal in the logarithm of the diameter.
std::vector<SizeClass> size_classes(const Sizes& sizes);
/// The share of a distribution's mass that lies between its cut-offs; 1 for classes.
double mass_between_cut_offs(const Sizes& sizes);
/// The largest diameter that can occur; 0 if there are no sizes.
double largest_diameter_m(const Sizes& sizes);
double smallest_diameter_m(const Sizes& sizes);

/// A rigid body of overlapping spheres, of one density in its union; in any unit of length and any
/// position: only its form counts.
struct ClumpShape {
  struct Sphere {
    Vec3 position = Vec3::Zero();
    double radius = 0.0;
    bool operator==(const Sphere&) const = default;
  };
  std::string name{};
  std::vector<Sphere> spheres{};
  bool operator==(const ClumpShape&) const = default;
};

/// Shapes that every case knows without defining them: "sinter_3", the three-sphere form of sinter
/// (see docs/methods/dem.md for the geometry and its reason).
const std::vector<ClumpShape>& shipped_clumps();

/// One kind of particles in a mixture.
struct Grains {
  std::string material{};
  std::string clump{};         ///< name of a ClumpShape; empty for spheres
  double mass_fraction = 1.0;  ///< of the mixture
  Sizes sizes{};
  bool operator==(const Grains&) const = default;
};

}  // namespace repose::scene
