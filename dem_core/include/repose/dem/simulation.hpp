// A simulation of particles between walls, step by step.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "repose/dem/checkpoint.hpp"
#include "repose/dem/contact_law.hpp"
#include "repose/scene/run_records.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem {

/// A sphere as seen from outside: everything at one time, SI.
struct Sphere {
  std::int32_t id = 0;        ///< from 0, in order of creation; for life
  std::int32_t body = 0;      ///< id of the body it is, or is part of
  std::int32_t material = 0;  ///< index into Case::materials
  double radius_m = 0.0;
  double mass_kg = 0.0;  ///< in a clump its share of the body's mass, in proportion to radius^3
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 angular_velocity = Vec3::Zero();
};

/// What particles did to one wall since the last reading.
struct WallLoad {
  Vec3 force_n = Vec3::Zero();  ///< mean over the steps
  /// About the centre of the wall's first rotation, else about the origin; mean over the steps.
  Vec3 torque_n_m = Vec3::Zero();
  double work_j = 0.0;  ///< done by the wall on particles
};

/// A rigid body: a clump, or a sphere, which is a clump of one.
struct Body {
  std::int32_t id = 0;        ///< from 0, in order of creation; for life
  std::int32_t material = 0;  ///< index into Case::materials
  std::int32_t spheres = 1;   ///< how many it consists of
  double radius_m = 0.0;      ///< of the sphere of its volume
  double mass_kg = 0.0;
  Vec3 inertia_kg_m2 = Vec3::Zero();  ///< principal moments
  Vec3 position = Vec3::Zero();       ///< of the centre of mass
  Vec3 velocity = Vec3::Zero();
  Vec3 angular_velocity = Vec3::Zero();
  /// Turns principal axes into the world's. A single sphere's orientation is not followed.
  std::array<double, 4> orientation_wxyz{1.0, 0.0, 0.0, 0.0};

  double kinetic_energy_j() const;
  Vec3 angular_momentum() const;  ///< about its centre, kg m^2/s
};

/// The deepest overlap of any contact, against the smaller radius.
struct LargestOverlap {
  double overlap_m = 0.0;
  double smaller_radius_m = 1.0;
  std::int32_t sphere = -1;  ///< id; -1 if nothing touched
  std::int32_t other = -1;   ///< id of a sphere or index of a wall
  bool is_at_wall = false;

  double ratio() const { return overlap_m / smaller_radius_m; }
};

/// When the domain is cut anew among processes; it changes no bit of the result.
enum class Balance {
  by_cost,  ///< at the start and whenever the costs of processes are too unequal
  never     ///< at the start only
};

struct SimulationOptions {
  /// Time step; 0 takes Case::time_step_rayleigh_fraction of the smallest Rayleigh time present.
  double time_step_s = 0.0;
  /// Skin of the neighbor lists in smallest radii; 0 lets it follow the pace of the particles. It
  /// changes no bit of the result.
  double skin_radii = 0.0;
  Balance balance = Balance::by_cost;
};

/// Owns all state of a run. Time advances by step(); everything in between is read only. One
/// thread; the same case gives the same bits in every run of one build, on any number of processes.
///
/// Where a launcher of MPI started several processes and a ParallelSession lives, they simulate the
/// case together. Then every function is to be called by all of them in the same order, an error is
/// thrown by all, and bodies(), spheres() and the tables of a checkpoint are complete on rank 0 and
/// empty elsewhere; other results are the same on all.
class Simulation {
 public:
  /// Takes materials, walls, domain, gravity and particles from the case, and places its fill.
  /// Output and when a stage ends are run_case()'s matter. Throws InputError for a case that cannot
  /// be simulated and SimulationError if the fill does not fit.
  explicit Simulation(const scene::Case& scene, const SimulationOptions& options = {});
  /// Goes on from a checkpoint of the same case as if the simulation had never stopped: bit for
  /// bit, in one build. Throws InputError as require_same_case(), StorageError.
  Simulation(const scene::Case& scene, const Checkpoint& checkpoint,
             Balance balance = Balance::by_cost);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Adds a particle before the first step; returns the id of the body. Throws InputError.
  std::int32_t add_particle(const scene::Particle& particle);

  /// Advances n time steps. Throws SimulationError, naming sphere, place and speed, if one leaves
  /// the domain, has no finite position, becomes ten times as fast as anything before, or overlaps
  /// by more than 30 % of its radius and twice what an impact at the largest speed gives, or 50 %.
  void step(std::int64_t n = 1);
  /// Takes a wall, or all walls of a box, away. Throws InputError for an unknown name.
  void open(const std::string& wall);
  /// Begins a stage of the case: opens its walls; its motions and its rain count their time from
  /// now. Throws InputError for an unknown name.
  void begin_stage(const std::string& name);

  std::int64_t steps() const;
  double time_s() const;
  double time_step_s();      ///< fixed from the first call or the first step on
  std::size_t size() const;  ///< spheres
  double mass_kg() const;
  scene::Ledger ledger() const;
  /// Rain that is still to come, kg; 0 if there is none.
  double outstanding_rain_kg() const;
  /// All spheres by id, velocities at time_s().
  std::vector<Sphere> spheres();
  /// All bodies by id, velocities at time_s().
  std::vector<Body> bodies();
  /// Adds up, over all bodies, `count` numbers that `numbers_of` writes for each; the sums are
  /// exact to 2^-80, so that they have the same bits in any order and on any number of processes.
  using NumbersOfBody = std::function<void(const Body& body, std::span<double> numbers)>;
  std::vector<double> sum_over_bodies(std::size_t count, const NumbersOfBody& numbers_of);
  /// Translational and rotational, at time_s().
  double kinetic_energy_j();
  /// The ledger of energy at time_s(). Throws InputError unless Output::energy of the case is set.
  scene::EnergyRow energy();
  /// The contacts of each pair of materials, in the order of Case::pairs.
  std::vector<scene::PairContacts> contact_statistics();
  /// Touching pairs and contacts with walls.
  std::size_t contacts();
  /// Since the last call of this function.
  LargestOverlap take_largest_overlap();
  /// Loads on the walls, in the order of the case, since the last call of this function.
  std::vector<WallLoad> take_wall_loads();
  /// Where the walls are, in the order of the case.
  std::vector<scene::WallPose> wall_poses() const;
  /// What the meshes among the walls are, in the order of the case; none for other shapes.
  std::vector<std::optional<scene::MeshReport>> mesh_reports() const;
  /// All that the simulation needs to go on; nothing changes, the run goes on as without.
  Checkpoint checkpoint();
  /// Stands for all bits of bodies and contacts: equal for equal states, however they came about.
  std::uint64_t state_hash();
  /// How often the domain was cut among processes; 0 with one.
  std::int64_t cuts() const;
  /// Neighbor list builds so far.
  std::int64_t rebuilds() const;
  /// Pairs of ids in the neighbor list of this process, smaller first, sorted; for tests.
  std::vector<std::pair<std::int32_t, std::int32_t>> listed_pairs();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace repose::dem
