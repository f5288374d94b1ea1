// Materials, the coefficients of their pairs and the variant of the contact law.
#pragma once

#include <string>

namespace repose::scene {

/// A material of particles or walls. A case file may give shear_modulus_pa instead of
/// youngs_modulus_pa; E = 2 G (1 + nu).
struct Material {
  std::string name{};
  double density_kg_m3 = 0.0;
  double youngs_modulus_pa = 0.0;
  double poissons_ratio = 0.25;  ///< in (-1, 0.5]
  bool operator==(const Material&) const = default;
};

/// Coefficients of one pair of materials; order does not matter, each pair stands once.
struct PairCoefficients {
  std::string first{}, second{};
  double restitution = 0.5;      ///< in (0, 1]
  double mu_s = 0.0;             ///< sliding friction
  double mu_r = 0.0;             ///< rolling friction
  double rolling_damping = 0.3;  ///< ratio to critical damping of the rolling spring
  /// Simplified JKR cohesion: an attraction of this times the area in which the undeformed spheres
  /// intersect.
  double cohesion_energy_density_j_m3 = 0.0;
  bool operator==(const PairCoefficients&) const = default;
};

/// What becomes of the attraction that damping causes just before two bodies separate.
enum class Tail {
  keep,  ///< it acts: the closed form of the damping for a given restitution holds [Antypov2011]
  clip   ///< F_n >= 0, damping corrected so that the restitution is right all the same, and the
         ///< total tangential force is capped: the variant that is exact in gross sliding
};

/// Which rolling resistance [Ai2011].
enum class RollingModel {
  c,  ///< spring and dashpot, limited: comes to rest
  a   ///< a torque of constant size against the relative rolling; no rolling damping
};

/// Stiffness of the rolling spring of type C.
enum class RollingStiffness {
  ai,  ///< 2.25 k_n (mu_r R*)^2 [Ai2011]
  kt   ///< k_t R*^2, some fifty times stiffer at mu_r = 0.1
};

/// Whose order of operations the contact history follows.
enum class Compatibility {
  none,     ///< synchronised with the half step, turned with the contact, length kept [Vyas2025]
  liggghts  ///< added first, then projected without restoring its length; rolling torque not turned
};

/// The variant of the law "hm1" for all contacts of a case.
struct ContactModel {
  Tail tail = Tail::keep;
  RollingModel rolling = RollingModel::c;
  RollingStiffness rolling_stiffness = RollingStiffness::ai;
  Compatibility compatibility = Compatibility::none;
  bool operator==(const ContactModel&) const = default;
};

}  // namespace repose::scene
