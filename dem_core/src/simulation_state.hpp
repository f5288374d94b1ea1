// The state of a simulation and its parts of a time step.
#pragma once

#include <exception>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "contact/contact_forces.hpp"
#include "insertion/rain.hpp"
#include "neighbor/skin.hpp"
#include "parallel/domain.hpp"
#include "particles/integration.hpp"
#include "repose/dem/simulation.hpp"

namespace repose::dem {

/// All bodies of these spheres and clumps, by id; velocities of half a step before are brought to
/// now.
std::vector<Body> bodies_of(const Spheres& spheres, const Clumps& clumps, const Vec3& gravity,
                            double half_step_s);

/// "(x, y, z) m", to the micrometre.
std::string place_text(const Vec3& x);

struct Simulation::State {
  State(const scene::Case& given, const SimulationOptions& chosen)
      : scene(given),
        options(chosen),
        box(given),
        walls(given),
        laws(given, given.stages.empty() ? nullptr : &given.stages.front()),
        forms(scene),
        domain(Communicator::of_launcher()) {}

  scene::Case scene;
  SimulationOptions options;
  Box box;
  Walls walls;
  LawTable laws;
  ClumpForms forms;
  Spheres spheres;
  Clumps clumps;
  std::vector<RainSource> rains;
  std::vector<scene::Region> sinks;  // regions that remove what comes into them
  std::map<std::string, double> stage_start_s;
  NeighborLists lists;
  ContactPool pool;
  LargestOverlap largest_overlap;  // since it was last taken
  double largest_speed = 0.0;      // of any sphere when they were looked at
  WallContacts wall_contacts;
  std::int64_t wall_load_steps = 0;  // summed in the loads of walls
  scene::Ledger ledger;
  ExactEnergies energies;            // stored at the last step, lost in all steps over their length
  scene::EnergyRow counted;          // what came and went with bodies
  ExactVectorSum wrapped_kg_m;       // mass times the way of all that crossed a periodic side
  ExactSum wall_work_j;              // of loads already taken
  double initial_j = 0.0;            // kinetic, potential and stored at the start
  std::int64_t spheres_present = 0;  // of all processes
  std::int32_t next_sphere = 0;      // ids
  std::int32_t next_body = 0;
  double dt = 0.0;            // 0 until prepared
  double least_radius = 0.0;  // present or to come
  Skin skin{0.0, 1.0};
  std::int64_t steps = 0;
  std::int64_t listed_step = 0;  // when the lists were built
  std::int64_t rebuilds = 0;
  Domain domain;
  std::exception_ptr pending;  // what went wrong here since processes last agreed

  double time_s() const { return static_cast<double>(steps) * dt; }
  std::int32_t check_and_add(const scene::Particle& particle);
  std::int32_t add(const scene::Particle& particle);
  void place_all();
  void prepare_insertion();
  void prepare();
  void require_pairs() const;
  double smallest_rayleigh_time_s() const;
  double smallest_radius() const;
  void check_speed(double step) const;
  void check_wall_speed() const;
  void check_displacement(double moved) const;
  void check_places(const DriftResult& of_spheres, const DriftResult& of_clumps) const;
  /// With one process what `act` throws is thrown; else it is kept until processes agree.
  template <class Act>
  void attempt(Act&& act);
  /// The way of the fastest sphere of all processes and whether any of them has bodies in sinks;
  /// throws on all what is pending on one.
  struct Agreed {
    double moved;
    bool removes;
  };
  Agreed agree(double moved, bool removes);
  bool keep_lists_valid(double moved);
  Population population() { return {spheres, clumps, lists, pool, wall_contacts}; }
  /// All bodies and contacts of all processes as one would hold them, on root; elsewhere nothing.
  struct Whole;
  Whole gathered();
  /// Every sum over all processes, by name, for checkpoints and output.
  std::vector<std::pair<std::string, ExactSum*>> exact_sums();
  /// Their values over all processes, the same everywhere.
  using Totals = std::map<std::string, ExactSum>;
  Totals totals();
  /// What contacts of all processes store now.
  double stored_j();
  LargestOverlap largest_overlap_of_all() const;
  /// Over all processes; before the first step all of them hold all.
  void sum_up(std::span<std::int64_t> values) const {
    if (dt > 0.0) domain.communicator().add_up(values);
  }
  void sum_up(std::span<ExactSum> values) const {
    if (dt > 0.0) domain.communicator().add_up(values);
  }
  std::vector<Sphere> seen_spheres(const Spheres& all, const Clumps& of_them) const;
  void one_step();
  /// What becomes of the order of the spheres when lists are built: spheres added since the last
  /// build need sorting.
  enum class Order { kept, sorted };
  /// The order of spheres, hence of sums, changes at steps that the case alone determines; when
  /// lists wear out depends on the skin and changes nothing.
  void rebuild_lists(Order order = Order::sorted);
  void compute_forces(double history_dt);
  void count_dissipation(const ExactEnergies& now, double span);
  /// Of all processes, on root.
  std::vector<Body> bodies();
  std::vector<double> sum_over_bodies(std::size_t count, const NumbersOfBody& numbers_of) const;
  double mechanical_j(const Body& body) const;
  void kick_all(double span);
  void let_rain_fall();
  void occupy(const scene::Rain& rain, double largest, OccupiedSpace& occupied);
  double rain_time_s(const scene::Rain& rain) const;
  void remove_from_all(const std::vector<std::int32_t>& here);
  std::vector<std::int32_t> bodies_in_sinks() const;
  void remove(const std::vector<std::int32_t>& bodies);
  ClearOfWalls clear_of_walls() const;
  Checkpoint checkpoint();
  void restore(const Checkpoint& saved);
  void restore_bodies_and_lists(const Checkpoint& saved);
  void restore_stages(const Checkpoint& saved);
  void restore_sums(const Checkpoint& saved);
  std::uint64_t hash();
  void watch_overlap(const DeepestOverlap& now);
  double allowed_overlap_ratio(const DeepestOverlap& now) const;
  void watch_speed();
  void check_jump(std::size_t i) const;
  std::size_t fastest_sphere() const;
  std::string overlap_text(const DeepestOverlap& now, double allowed) const;
  [[noreturn]] void lost(std::size_t i) const;
  std::string name_of(std::size_t i) const;
  std::string speed_and_time(std::size_t i) const;
};

/// What a single process would hold.
struct Simulation::State::Whole {
  Spheres spheres;
  Clumps clumps;
  std::vector<ContactRecord> contacts;  ///< by ids
  WallContacts wall_contacts;
};

template <class Act>
void Simulation::State::attempt(Act&& act) {
  if (domain.is_alone()) return act();
  try {
    act();
  } catch (...) {
    if (!pending) pending = std::current_exception();
  }
}

}  // namespace repose::dem
