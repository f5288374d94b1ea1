// What a simulation is: materials, walls, filling, stages and output, with its file and its checks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "repose/scene/contact_model.hpp"
#include "repose/scene/grains.hpp"
#include "repose/scene/insertion.hpp"
#include "repose/scene/wall.hpp"

namespace repose {
class TomlTable;
}

namespace repose::scene {

/// What limits a region to a cylinder.
struct RegionCylinder {
  Vec3 start = Vec3::Zero();  ///< ends of the axis
  Vec3 end = Vec3::Zero();
  double radius_m = 0.0;
  bool operator==(const RegionCylinder&) const = default;
};

/// A place whose mass is recorded; a particle is in it if its centre is in the box [lower, upper),
/// whose bounds may be infinite, and in the cylinder if there is one.
struct Region {
  std::string name{};
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  std::optional<RegionCylinder> cylinder{};
  bool removes = false;  ///< particles that come into it are taken out of the simulation
  bool operator==(const Region&) const = default;
};

/// Whether a point lies in the region.
bool is_inside(const Region& region, const Vec3& x);

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

/// What holds for all pairs while a stage lasts, in place of their own: a filling whose outcome
/// does not depend on what is calibrated.
struct StageCoefficients {
  double restitution = 0.5;  ///< in (0, 1]
  double mu_s = 0.0;
  double mu_r = 0.0;
  bool operator==(const StageCoefficients&) const = default;
};

/// A span of time that begins with walls being taken away.
struct Stage {
  std::string name{};
  std::vector<std::string> opens{};  ///< names of walls; the name of a box means all of its faces
  double duration_s = 0.0;           ///< at most
  double minimum_s = 0.0;            ///< no criterion ends it earlier
  std::optional<AtRest> at_rest{};
  std::optional<FlowEnds> flow_ends{};
  std::optional<StageCoefficients> coefficients{};
  bool operator==(const Stage&) const = default;
};

struct Output {
  double snapshot_interval_s = 0.0;  ///< 0: only at the end of each stage
  double series_interval_s = 0.005;
  bool vtp = false;     ///< snapshots also as VTP files for ParaView
  bool energy = false;  ///< the energy ledger, which costs a few per cent of time
  /// Wall time between checkpoints, from which a run that was stopped goes on; 0: only on signals.
  double checkpoint_wall_time_s = 300.0;
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
  ContactModel contact{};
  std::vector<Material> materials{};
  std::vector<PairCoefficients> pairs{};
  std::vector<ClumpShape> clumps{};  ///< besides shipped_clumps()
  std::vector<Wall> walls{};
  std::vector<Motion> motions{};
  std::vector<Region> regions{};
  std::optional<Fill> fill{};
  std::vector<Rain> rains{};
  std::vector<ParticleTable> particle_tables{};
  std::vector<Particle> particles{};
  std::vector<Stage> stages{};
  Output output{};
  /// What the case was made from, by name: recorded, without effect on the simulation.
  std::map<std::string, double> parameters{};
  bool operator==(const Case&) const = default;
};

/// Reads and validates a case file; its keys are listed in docs/methods/dem.md. Throws StorageError
/// if it cannot be read, InputError with file and line, or as validate() does.
Case read_case(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
Case parse_case(std::string_view text, const std::string& name);
/// The same from a table, in which expressions may stand for numbers; files are relative to
/// `folder`. Other keys may stand beside those of a case if they were read before.
Case case_from(const TomlTable& table, const std::filesystem::path& folder);

/// A case file that reads back equal, bit for bit. Boxes appear as their walls.
std::string case_text(const Case& scene);
void write_case(const std::filesystem::path& path, const Case& scene);

/// What decides a run until its first `stages` stages have ended, for comparison, not to be run:
/// cases with equal beginnings are at that time in the same state, bit for bit. Later stages are
/// left out, as are coefficients of pairs if none of the first stages uses them; of motions that
/// begin with later stages only the walls, the kind and the axis count.
Case beginning_of(const Case& scene, std::size_t stages);

/// Throws InputError naming the quantity, its value and what is allowed if a simulation could not
/// be started or would make no sense: a missing pair of materials, unknown names, sizes that do not
/// fit.
void validate(const Case& scene);

/// Reads the particles of a table. Throws InputError or StorageError naming file, column and row.
std::vector<Particle> load_particles(const Case& scene, const ParticleTable& table);

/// A clump shape of the case or a shipped one; throws InputError that lists the known ones.
const ClumpShape& clump_shape(const Case& scene, const std::string& name);
/// Index of a material by name; throws InputError that lists the known ones.
int material_index(const Case& scene, const std::string& name);
/// Index into Case::pairs for two material indices, -1 if there is none.
int pair_index(const Case& scene, int first, int second);
/// The walls meant by a name in Stage::opens, as indices; empty if there are none.
std::vector<int> walls_named(const Case& scene, const std::string& name);

}  // namespace repose::scene
