// The state of a simulation and its parts of a time step.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "contact/contact_forces.hpp"
#include "insertion/rain.hpp"
#include "neighbor/skin.hpp"
#include "particles/integration.hpp"
#include "repose/dem/simulation.hpp"

namespace repose::dem {

/// "(x, y, z) m", to the micrometre.
std::string place_text(const Vec3& x);

struct Simulation::State {
  State(const scene::Case& given, const SimulationOptions& chosen)
      : scene(given), options(chosen), box(given), walls(given), laws(given), forms(scene) {}

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
  ContactEnergies stored;        // of the last step, if the ledger of energy is kept
  scene::EnergyRow counted;      // what is summed over steps: dissipation, insertion, removal
  Vec3 wrapped_kg_m{0, 0, 0};    // mass times the way of all that crossed a periodic side
  double wall_work_j = 0.0;      // of loads already taken
  double initial_j = 0.0;        // kinetic, potential and stored at the start
  std::int32_t next_sphere = 0;  // ids
  std::int32_t next_body = 0;
  double dt = 0.0;            // 0 until prepared
  double least_radius = 0.0;  // present or to come
  Skin skin{0.0, 1.0};
  std::int64_t steps = 0;
  std::int64_t listed_step = 0;  // when the lists were built
  std::int64_t rebuilds = 0;

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
  void keep_lists_valid(double moved);
  void one_step();
  /// The order of spheres, hence of sums, changes at steps that the case alone determines; when
  /// lists wear out depends on the skin and changes nothing.
  void rebuild_lists(Order order = Order::sorted);
  void compute_forces(double history_dt);
  void count_dissipation(const ContactEnergies& now, double span);
  std::vector<Body> bodies() const;
  double mechanical_j(const Body& body) const;
  void kick_all(double span);
  void let_rain_fall();
  double rain_time_s(const scene::Rain& rain) const;
  void remove_what_is_in_sinks();
  std::vector<std::int32_t> bodies_in_sinks() const;
  ClearOfWalls clear_of_walls() const;
  Checkpoint checkpoint() const;
  void restore(const Checkpoint& saved);
  void restore_bodies_and_lists(const Checkpoint& saved);
  void restore_walls(const Checkpoint& saved);
  void restore_sums(const Checkpoint& saved);
  std::uint64_t hash() const;
  void watch_overlap(const DeepestOverlap& now);
  double allowed_overlap_ratio(const DeepestOverlap& now) const;
  void watch_speed();
  std::size_t fastest_sphere() const;
  std::string overlap_text(const DeepestOverlap& now, double allowed) const;
  [[noreturn]] void lost(std::size_t i) const;
  std::string name_of(std::size_t i) const;
  std::string speed_and_time(std::size_t i) const;
};

}  // namespace repose::dem
