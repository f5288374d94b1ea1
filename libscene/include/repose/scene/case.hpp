// What a simulation is: materials, walls, filling, stages and output, with its file and its checks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace repose::scene {

using Vec3 = Eigen::Vector3d;

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
  bool operator==(const PairCoefficients&) const = default;
};

/// A size class; equal bounds are one size. Within it mass is spread uniformly over the diameter.
struct SizeClass {
  double lower_diameter_m = 0.0;
  double upper_diameter_m = 0.0;
  double mass_fraction = 1.0;
  bool operator==(const SizeClass&) const = default;
};

enum class WallShape { plane, rectangle };

/// A plane bounds the half-space its normal points into, which is where the particles are; a
/// rectangle spans origin + a u + b v with a, b in [0, 1] and pushes on both of its sides.
struct Wall {
  std::string name{};
  std::string material{};
  WallShape shape = WallShape::rectangle;
  Vec3 origin = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< of a plane, any length; zero for a rectangle
  Vec3 edge_u = Vec3::Zero();  ///< of a rectangle; perpendicular to edge_v
  Vec3 edge_v = Vec3::Zero();
  bool operator==(const Wall&) const = default;
};

/// The six faces of an axis-parallel box as rectangles named NAME.-x, NAME.+x, ... NAME.+z, without
/// those listed in `open` ("-x", "+z", ...). What `[[box]]` of a case file expands to.
std::vector<Wall> box_walls(const std::string& name, const std::string& material, const Vec3& lower,
                            const Vec3& upper, const std::vector<std::string>& open);

/// A box whose mass is recorded; a particle is in it if its centre is in [lower, upper). Bounds may
/// be infinite.
struct Region {
  std::string name{};
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  bool operator==(const Region&) const = default;
};

/// Particles of one material, poured as one layer.
struct Layer {
  std::string material{};
  double mass_kg = 0.0;
  std::vector<SizeClass> sizes{};  ///< mass fractions sum to 1
  bool operator==(const Layer&) const = default;
};

/// Layers placed over each other by random sequential addition in the column of `lower`-`upper`,
/// without overlap among themselves and with walls; nothing is placed above upper.z.
struct Fill {
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  double solid_fraction = 0.33;  ///< of the loose column, before it falls; at most 0.36
  std::vector<Layer> layers{};   ///< bottom first
  bool operator==(const Fill&) const = default;
};

/// A particle placed by hand.
struct Particle {
  std::string material{};
  Vec3 position = Vec3::Zero();          ///< m
  Vec3 velocity = Vec3::Zero();          ///< m/s
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s
  double radius_m = 0.0;
  bool operator==(const Particle&) const = default;
};

/// A stage ends when the kinetic energy stayed below kinetic_energy_ratio * sum(m g d_mean) for
/// window_s.
struct AtRest {
  double kinetic_energy_ratio = 1e-4;
  double window_s = 0.05;
  bool operator==(const AtRest&) const = default;
};

/// A stage ends when during the last window_s the mass in `region` fell by less than `fraction` of
/// what has left it since the stage began (of what it held then, if nothing has left).
struct FlowEnds {
  std::string region{};
  double fraction = 0.005;
  double window_s = 0.2;
  bool operator==(const FlowEnds&) const = default;
};

/// A span of time that begins with walls being taken away.
struct Stage {
  std::string name{};
  std::vector<std::string> opens{};  ///< names of walls; the name of a box means all of its faces
  double duration_s = 0.0;           ///< at most
  double minimum_s = 0.0;            ///< no criterion ends it earlier
  std::optional<AtRest> at_rest{};
  std::optional<FlowEnds> flow_ends{};
  bool operator==(const Stage&) const = default;
};

struct Output {
  double snapshot_interval_s = 0.0;  ///< 0: only at the end of each stage
  double series_interval_s = 0.005;
  bool operator==(const Output&) const = default;
};

struct Periodic {
  bool x = false, y = false, z = false;
  bool operator==(const Periodic&) const = default;
};

struct Case {
  std::uint64_t seed = 1;                     ///< below 2^63
  double time_step_rayleigh_fraction = 0.15;  ///< at most 0.5
  Vec3 gravity_m_s2{0.0, 0.0, -9.81};
  Vec3 lower_m = Vec3::Zero();  ///< the domain: its extent is the period of a periodic direction;
  Vec3 upper_m = Vec3::Zero();  ///< elsewhere a particle whose centre leaves it is lost, an error
  Periodic periodic{};
  std::vector<Material> materials{};
  std::vector<PairCoefficients> pairs{};
  std::vector<Wall> walls{};
  std::vector<Region> regions{};
  std::optional<Fill> fill{};
  std::vector<Particle> particles{};
  std::vector<Stage> stages{};
  Output output{};
  bool operator==(const Case&) const = default;
};

/// Reads and validates a case file; its keys are listed in docs/methods/dem.md. Throws StorageError
/// if it cannot be read, InputError with file and line, or as validate() does.
Case read_case(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
Case parse_case(std::string_view text, const std::string& name);

/// A case file that reads back equal, bit for bit. Boxes appear as their walls.
std::string case_text(const Case& scene);
void write_case(const std::filesystem::path& path, const Case& scene);

/// Throws InputError naming the quantity, its value and what is allowed if a simulation could not
/// be started or would make no sense: a missing pair of materials, unknown names, sizes that do not
/// fit.
void validate(const Case& scene);

/// Index of a material by name; throws InputError that lists the known ones.
int material_index(const Case& scene, const std::string& name);
/// Index into Case::pairs for two material indices, -1 if there is none.
int pair_index(const Case& scene, int first, int second);
/// The walls meant by a name in Stage::opens, as indices; empty if there are none.
std::vector<int> walls_named(const Case& scene, const std::string& name);

}  // namespace repose::scene
