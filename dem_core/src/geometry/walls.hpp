// The walls of a simulation: their facets, where they are now and what acts on them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/facet_tree.hpp"
#include "motion/wall_motion.hpp"
#include "parallel/exact_sum.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem {

/// One wall of the case.
struct WallBody {
  int material = 0;
  bool present = true;           ///< false once a stage has taken it away
  double smooth_cosine = 1.0;    ///< contacts of one patch whose normals are closer are one
  std::int32_t first_facet = 0;  ///< its facets in Walls::facets()
  std::int32_t last_facet = 0;
  FacetTree tree;
  WallMotion motion;
  WallState now{};
  Twist half_twist{};  ///< half a step before `now`, the time of the velocities of spheres
  Pose before{};       ///< now, at the last advance()
  Pose listed{};       ///< when the neighbor lists were built
  std::optional<scene::MeshReport> report{};  ///< on the mesh as it was loaded
};

/// Sums over steps of what particles do to a wall.
struct WallLoadSum {
  ExactVectorSum force;   ///< on the wall
  ExactVectorSum torque;  ///< about WallState::reference
  ExactSum work;          ///< of the wall on particles, J
};

/// A facet near a sphere; it cannot touch before sphere and wall together have moved by the gap.
struct NearFacet {
  std::int32_t facet;
  double gap;  ///< between the surfaces, negative where they overlap
};

/// All walls; each has the facets of its shape in the frame in which it was drawn, and a pose.
class Walls {
 public:
  /// Reads the meshes. Throws InputError as scene::load_mesh() and require_periodic(), and for a
  /// plane that turns about another axis than its normal.
  explicit Walls(const scene::Case& scene);

  std::size_t size() const { return bodies_.size(); }
  const WallBody& at(std::size_t wall) const { return bodies_[wall]; }
  const Facet& facet(std::int32_t i) const { return facets_[static_cast<std::size_t>(i)]; }
  const WallBody& wall_of(const Facet& facet) const {
    return bodies_[static_cast<std::size_t>(facet.wall)];
  }

  /// Takes a wall away.
  void open(std::size_t wall) { bodies_[wall].present = false; }
  /// Motions of this stage begin.
  void begin_stage(const std::string& name, double time_s);
  /// Brings all walls to where they are at this time; dt is the step that ends then.
  void advance(double time_s, double dt);

  /// How far any point of a wall that is present is at most from where it was at the last
  /// mark_listed(); 0 for a surface that moves in itself: a plane along itself, a surface of
  /// revolution about its axis.
  double displacement() const;
  void mark_listed();
  /// The wall that is present and moved most in the last advance(), and how far in the same sense.
  struct LargestStep {
    std::size_t wall = 0;
    double distance = 0.0;
  };
  LargestStep largest_step() const;

  /// The point of facet i that is closest to x, both in the world.
  ClosestPoint closest_point(std::int32_t i, const Vec3& x) const;
  /// Appends the facets of all present walls that are closer than `largest_gap` to a sphere.
  void add_near(const Vec3& x, double radius, double largest_gap,
                std::vector<NearFacet>& facets) const;
  /// Whether a sphere touches no wall.
  bool is_clear(const Vec3& x, double radius) const;

  WallLoadSum& load(std::size_t wall) { return loads_[wall]; }
  const std::vector<WallLoadSum>& loads() const { return loads_; }
  void clear_loads() { loads_.assign(bodies_.size(), {}); }

 private:
  void number_patches();
  void join_patches(std::int32_t kept, std::int32_t ended);

  std::vector<Facet> facets_;
  std::vector<WallBody> bodies_;
  std::vector<WallLoadSum> loads_;
};

}  // namespace repose::dem
