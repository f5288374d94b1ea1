// Particles that come in at a rate.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "insertion/draw_grains.hpp"
#include "insertion/placement.hpp"

namespace repose::dem {

/// One rain of a case: which particles, in which order, and how many have come.
class RainSource {
 public:
  /// Draws all particles in a random order; numbers come from streams of their own for each rain.
  /// Throws InputError if its mass is less than half of the smallest particle.
  RainSource(const scene::Case& scene, std::size_t number, ClumpForms& forms);

  const scene::Rain& rain() const { return rain_; }
  /// The smallest sphere that will come of each kind that comes at all.
  struct Smallest {
    std::string material;
    double radius;  ///< m
  };
  const std::vector<Smallest>& smallest_of_kinds() const { return smallest_; }
  /// Smallest and largest sphere that will come, m.
  double smallest_radius() const;
  double largest_radius() const { return largest_radius_; }
  bool is_finished() const { return next_ == grains_.size(); }
  double placed_kg() const { return placed_kg_; }
  /// What has come, and how often it was tried: all that changes.
  struct Progress {
    std::int64_t placed = 0;
    std::int64_t attempts = 0;
    double placed_kg = 0.0;
  };
  Progress progress() const {
    return {static_cast<std::int64_t>(next_), static_cast<std::int64_t>(attempts_), placed_kg_};
  }
  /// Throws StorageError if more than all has come.
  void go_on_from(const Progress& progress);
  /// Whether a particle is due `time_s` after the rain began.
  bool is_due(double time_s) const;

  /// Places what is due, each into `occupied`, as long as there is room. Throws SimulationError if
  /// it falls behind by more than a second's mass.
  std::vector<scene::Particle> fall(double time_s, const Box& box,
                                    const ClearOfWalls& clear_of_walls, OccupiedSpace& occupied);

 private:
  scene::Rain rain_;
  std::vector<const scene::ClumpForm*> forms_;  // of each kind
  std::vector<Grain> grains_;
  std::size_t next_ = 0;
  std::uint64_t attempts_ = 0;
  std::uint64_t seed_;
  std::uint64_t stream_;
  double placed_kg_ = 0.0;
  std::vector<Smallest> smallest_;
  double largest_radius_ = 0.0;
};

}  // namespace repose::dem
