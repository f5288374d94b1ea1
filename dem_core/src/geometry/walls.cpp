#include "geometry/walls.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/mesh_period.hpp"
#include "geometry/smooth_patches.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

constexpr double kSameDirection = 1e-12;  // of the cosine

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// The facets of a shape, with patches numbered from 0 within it.
struct FacetsOf {
  const scene::Case& scene;
  const std::string& wall;
  std::optional<scene::MeshReport>& report;  // is set for a mesh

  std::vector<Facet> operator()(const scene::Plane& shape) const {
    return {plane_facet(shape.origin, shape.normal)};
  }
  std::vector<Facet> operator()(const scene::Rectangle& shape) const {
    return {rectangle_facet(shape.origin, shape.edge_u, shape.edge_v)};
  }
  std::vector<Facet> operator()(const scene::Disc& shape) const {
    return {revolved_facet(shape.centre, shape.normal, shape.inner_radius_m, shape.radius_m, 0.0)};
  }
  std::vector<Facet> operator()(const scene::Cone& shape) const {
    const Vec3 axis = shape.end - shape.start;
    return {
        revolved_facet(shape.start, axis, shape.start_radius_m, shape.end_radius_m, axis.norm())};
  }
  std::vector<Facet> operator()(const scene::Mesh& shape) const {
    const scene::LoadedMesh loaded = scene::load_mesh(shape);
    require_periodic(scene, wall, loaded);
    report = loaded.report;
    const std::vector<std::int32_t> patches = smooth_patches(loaded.mesh, shape.smooth_deg);
    std::vector<Facet> facets;
    facets.reserve(patches.size());
    for (std::size_t t = 0; t < patches.size(); ++t) {
      facets.push_back(triangle_facet(loaded.mesh.corner(t, 0), loaded.mesh.corner(t, 1),
                                      loaded.mesh.corner(t, 2)));
      facets.back().patch = patches[t];
    }
    return facets;
  }
};

void refuse_tilting_plane(const scene::Wall& wall, const scene::Case& scene) {
  const auto* plane = std::get_if<scene::Plane>(&wall.shape);
  if (plane == nullptr) return;
  const Vec3 normal = plane->normal.normalized();
  for (const scene::Motion& motion : scene.motions) {
    const auto* rotation = std::get_if<scene::Rotation>(&motion.path);
    if (rotation == nullptr ||
        cross(rotation->axis.normalized(), normal).norm() <= std::sqrt(kSameDirection))
      continue;
    for (const std::string& name : motion.walls)
      for (const int w : scene::walls_named(scene, name))
        if (scene.walls[static_cast<std::size_t>(w)].name == wall.name)
          throw InputError("wall \"" + wall.name +
                           "\": an infinite plane can turn about its normal only; make it a "
                           "rectangle or a disc");
  }
}

/// Calls visit for the corners of a box.
template <class Visit>
void for_corners(const Bounds& box, const Visit& visit) {
  for (int c = 0; c < 8; ++c)
    visit(Vec3((c & 1) != 0 ? box.upper.x() : box.lower.x(),
               (c & 2) != 0 ? box.upper.y() : box.lower.y(),
               (c & 4) != 0 ? box.upper.z() : box.lower.z()));
}

/// A bound on how far apart a wall is in two poses.
double distance_between(const Facet& first, const WallBody& wall, const Pose& a, const Pose& b) {
  const auto moved = [&](const Vec3& x) -> Vec3 { return a.to_world(x) - b.to_world(x); };
  const auto turned = [&](const Vec3& v) -> Vec3 {
    return a.direction_to_world(v) - b.direction_to_world(v);
  };
  if (first.kind == FacetKind::plane)
    return std::abs(moved(first.origin).dot(a.direction_to_world(first.normal)));
  if (first.kind == FacetKind::revolved) {
    // Fixed by its axis: a point moves with the axis at its height and turns with it.
    const double tilt = turned(first.normal).norm();
    return std::max(
        moved(first.origin).norm() + first.start_radius * tilt,
        moved(first.origin + first.length * first.normal).norm() + first.end_radius * tilt);
  }
  // A displacement is linear in the point, so that it is largest at a corner of the box.
  double largest = 0.0;
  for_corners(wall.tree.bounds(),
              [&](const Vec3& corner) { largest = std::max(largest, moved(corner).norm()); });
  return largest;
}

}  // namespace

Walls::Walls(const scene::Case& scene) {
  bodies_.reserve(scene.walls.size());
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const scene::Wall& wall = scene.walls[w];
    refuse_tilting_plane(wall, scene);
    const auto first = static_cast<std::int32_t>(facets_.size());
    std::optional<scene::MeshReport> report;
    for (Facet& facet : std::visit(FacetsOf{scene, wall.name, report}, wall.shape)) {
      facet.wall = static_cast<std::int32_t>(w);
      facets_.push_back(facet);
    }
    const auto last = static_cast<std::int32_t>(facets_.size());
    WallBody body{.material = scene::material_index(scene, wall.material),
                  .first_facet = first,
                  .last_facet = last,
                  .tree = FacetTree(facets_, first, last),
                  .motion = WallMotion(scene, w),
                  .report = report};
    if (const auto* mesh = std::get_if<scene::Mesh>(&wall.shape))
      body.smooth_cosine = std::cos(mesh->smooth_deg * std::numbers::pi / 180.0) - kSameDirection;
    body.now = body.motion.at(0.0);
    body.half_twist = body.now.twist;
    body.before = body.listed = body.now.pose;
    bodies_.push_back(std::move(body));
  }
  number_patches();
  clear_loads();
}

/// Numbers the patches of all walls; primitives of one material that move alike and are pieces of
/// one smooth surface share theirs.
void Walls::number_patches() {
  std::int32_t next = 0;
  for (WallBody& body : bodies_) {
    const std::int32_t offset = next;
    for (std::int32_t f = body.first_facet; f < body.last_facet; ++f) {
      std::int32_t& patch = facets_[index(f)].patch;
      patch += offset;
      next = std::max(next, patch + 1);
    }
  }
  const auto is_primitive = [](const WallBody& body) {
    return body.last_facet - body.first_facet == 1;
  };
  for (std::size_t w = 0; w < bodies_.size(); ++w)
    for (std::size_t other = 0; other < w; ++other) {
      const WallBody& a = bodies_[other];
      const WallBody& b = bodies_[w];
      if (is_primitive(a) && is_primitive(b) && a.material == b.material &&
          a.motion.same_as(b.motion) && are_one_surface(facet(a.first_facet), facet(b.first_facet)))
        join_patches(facet(a.first_facet).patch, facet(b.first_facet).patch);
    }
}

void Walls::join_patches(std::int32_t kept, std::int32_t ended) {
  for (const WallBody& body : bodies_) {
    std::int32_t& patch = facets_[index(body.first_facet)].patch;
    if (patch == ended) patch = kept;  // those of meshes are never joined
  }
}

void Walls::begin_stage(const std::string& name, double time_s) {
  for (WallBody& body : bodies_) body.motion.begin_stage(name, time_s);
}

void Walls::advance(double time_s, double dt) {
  for (WallBody& body : bodies_) {
    if (body.motion.empty()) continue;
    body.before = body.now.pose;
    body.now = body.motion.at(time_s);
    body.half_twist = body.motion.at(time_s - 0.5 * dt).twist;
  }
}

double Walls::displacement() const {
  double largest = 0.0;
  for (const WallBody& body : bodies_)
    if (body.present && !body.motion.empty())
      largest = std::max(
          largest, distance_between(facet(body.first_facet), body, body.now.pose, body.listed));
  return largest;
}

void Walls::mark_listed() {
  for (WallBody& body : bodies_) body.listed = body.now.pose;
}

Walls::LargestStep Walls::largest_step() const {
  LargestStep largest;
  for (std::size_t w = 0; w < bodies_.size(); ++w) {
    const WallBody& body = bodies_[w];
    if (!body.present || body.motion.empty()) continue;
    const double distance =
        distance_between(facet(body.first_facet), body, body.now.pose, body.before);
    if (distance > largest.distance) largest = {w, distance};
  }
  return largest;
}

ClosestPoint Walls::closest_point(std::int32_t i, const Vec3& x) const {
  const Facet& of = facet(i);
  const Pose& pose = wall_of(of).now.pose;
  if (pose.is_identity) return dem::closest_point(of, x);
  ClosestPoint point = dem::closest_point(of, pose.to_drawn(x));
  point.direction = pose.direction_to_world(point.direction);
  return point;
}

void Walls::add_near(const Vec3& x, double radius, double largest_gap,
                     std::vector<NearFacet>& facets) const {
  for (const WallBody& body : bodies_) {
    if (!body.present) continue;
    const Vec3 drawn = body.now.pose.to_drawn(x);
    body.tree.visit_near(drawn, radius + largest_gap, [&](std::int32_t i) {
      const double gap = dem::closest_point(facet(i), drawn).distance - radius;
      if (gap < largest_gap) facets.push_back({i, gap});
    });
  }
}

bool Walls::is_clear(const Vec3& x, double radius) const {
  for (const WallBody& body : bodies_) {
    if (!body.present) continue;
    const Vec3 drawn = body.now.pose.to_drawn(x);
    bool clear = true;
    body.tree.visit_near(drawn, radius, [&](std::int32_t i) {
      clear = clear && !(dem::closest_point(facet(i), drawn).distance < radius);
    });
    if (!clear) return false;
  }
  return true;
}

}  // namespace repose::dem
