// Walls: their shapes, and what a periodic direction asks of them.
#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

/// Checks one shape; `what` begins the messages, "wall "NAME": ".
struct ShapeCheck {
  const std::string& what;

  void operator()(const Plane& plane) const {
    require_finite(what + "origin_m", plane.origin);
    require_direction("normal", plane.normal, "the direction towards the particles");
  }
  void operator()(const Rectangle& rectangle) const {
    require_finite(what + "origin_m", rectangle.origin);
    require_finite(what + "edge_u_m", rectangle.edge_u);
    require_finite(what + "edge_v_m", rectangle.edge_v);
    const double u = rectangle.edge_u.norm();
    const double v = rectangle.edge_v.norm();
    if (!(u > 0.0) || !(v > 0.0))
      throw InputError(what + "an edge has no length; give edge_u_m and edge_v_m");
    if (std::abs(rectangle.edge_u.dot(rectangle.edge_v)) > 1e-9 * u * v)
      throw InputError(what + "edge_u_m and edge_v_m must be perpendicular");
  }
  void operator()(const Disc& disc) const {
    require_finite(what + "centre_m", disc.centre);
    require_direction("normal", disc.normal, "the direction of the disc's axis");
    require_positive(what + "radius_m", disc.radius_m);
    require_non_negative(what + "inner_radius_m", disc.inner_radius_m);
    if (disc.inner_radius_m >= disc.radius_m)
      refuse(what + "inner_radius_m", disc.inner_radius_m,
             "must be below radius_m = " + shortest(disc.radius_m));
  }
  void operator()(const Cone& cone) const {
    require_finite(what + "start_m", cone.start);
    require_finite(what + "end_m", cone.end);
    if (!((cone.end - cone.start).norm() > 0.0))
      throw InputError(what + "start_m and end_m are the same point; the axis needs a length");
    require_non_negative(what + "start_radius_m", cone.start_radius_m);
    require_non_negative(what + "end_radius_m", cone.end_radius_m);
    if (cone.start_radius_m == 0.0 && cone.end_radius_m == 0.0)
      throw InputError(what + "radius is 0 at both ends; give one above 0");
  }
  void operator()(const Mesh& mesh) const {
    if (mesh.file.empty()) throw InputError(what + "file is empty; name an STL file");
    require_positive(what + "scale", mesh.scale);
    require_finite(what + "translation_m", mesh.translation);
    if (!(mesh.smooth_deg >= 0.0 && mesh.smooth_deg < 90.0))
      refuse(what + "smooth_deg", mesh.smooth_deg, "must be in [0, 90)");
  }

  void require_direction(const char* key, const Vec3& direction, const char* meaning) const {
    require_finite(what + key, direction);
    if (!(direction.norm() > 0.0)) throw InputError(what + key + " is zero; give " + meaning);
  }
};

/// An extent along one axis.
struct Span {
  double lower, upper;
};

/// What a disc of this radius about `centre` covers.
Span span_of_disc(const Vec3& centre, const Vec3& normal, double radius, int axis) {
  const double along = normal[axis] / normal.norm();
  const double half = radius * std::sqrt(std::max(0.0, 1.0 - along * along));
  return {centre[axis] - half, centre[axis] + half};
}

/// Along a periodic direction a wall must go on as its images do, or lie within the period.
struct PeriodCheck {
  const Case& scene;
  const std::string& what;
  int axis;

  double slack() const { return 1e-9 * (scene.upper_m[axis] - scene.lower_m[axis]); }
  bool spans(const Span& s) const {
    return s.lower <= scene.lower_m[axis] + slack() && s.upper >= scene.upper_m[axis] - slack();
  }
  bool within(const Span& s) const {
    return s.lower >= scene.lower_m[axis] - slack() && s.upper <= scene.upper_m[axis] + slack();
  }
  std::string period() const {
    return "the period from " + shortest(scene.lower_m[axis]) + " to " +
           shortest(scene.upper_m[axis]) + " m of direction " + kAxes[axis];
  }
  [[noreturn]] void leaves(const Span& s) const {
    throw InputError(what + "reaches from " + shortest(s.lower) + " to " + shortest(s.upper) +
                     " m; it must lie within " + period());
  }

  void operator()(const Plane& plane) const {
    if (std::abs(plane.normal.normalized()[axis]) > 1e-9)
      throw InputError(what + "its normal has a component along the periodic direction " +
                       kAxes[axis] + "; planes must be parallel to it");
  }
  void operator()(const Rectangle& rectangle) const {
    for (const Vec3& edge : {rectangle.edge_u, rectangle.edge_v}) {
      if (std::abs(edge[axis]) < (1.0 - 1e-9) * edge.norm()) continue;
      const double start = rectangle.origin[axis];
      const double end = start + edge[axis];
      if (spans({std::min(start, end), std::max(start, end)})) return;
    }
    throw InputError(what + "must have an edge that spans the whole period from " +
                     shortest(scene.lower_m[axis]) + " to " + shortest(scene.upper_m[axis]) +
                     " m of direction " + kAxes[axis]);
  }
  void operator()(const Disc& disc) const {
    const Span span = span_of_disc(disc.centre, disc.normal, disc.radius_m, axis);
    if (!within(span)) leaves(span);
  }
  void operator()(const Cone& cone) const {
    const Vec3 along = cone.end - cone.start;
    const Span a = span_of_disc(cone.start, along, cone.start_radius_m, axis);
    const Span b = span_of_disc(cone.end, along, cone.end_radius_m, axis);
    const Span span{std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
    const bool is_cylinder_along = cone.start_radius_m == cone.end_radius_m &&
                                   std::abs(along[axis]) >= (1.0 - 1e-9) * along.norm();
    if (within(span) || (is_cylinder_along && spans(span))) return;
    if (is_cylinder_along)
      throw InputError(what + "its axis reaches from " + shortest(span.lower) + " to " +
                       shortest(span.upper) + " m; it must span " + period() + " or lie within it");
    leaves(span);
  }
  void operator()(const Mesh&) const {
  }  // its extent is known when the file is loaded, and checked there
};

}  // namespace

void check_walls(const Case& scene) {
  require_unique_names("wall", scene.walls);
  for (const Wall& wall : scene.walls) {
    const std::string what = "wall \"" + wall.name + "\": ";
    material_index(scene, wall.material);
    std::visit(ShapeCheck{what}, wall.shape);
    for (int k = 0; k < 3; ++k)
      if (is_periodic(scene, k)) std::visit(PeriodCheck{scene, what, k}, wall.shape);
  }
}

}  // namespace repose::scene
