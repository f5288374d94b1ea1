#include "repose/scene/clump_form.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {
namespace {

using Sphere = ClumpShape::Sphere;
using Gauss = boost::math::quadrature::gauss<double, 30>;
constexpr double kPi = std::numbers::pi;
constexpr int kPanels = 8;  // where a cap passes close to a pole, one alone leaves 1e-9

/// Integrals over the union: 1, x, y, z, xx, yy, zz, xy, xz, yz.
using Moments = Eigen::Matrix<double, 10, 1>;

/// What another sphere hides of this one: unit directions u with u . offset > level.
struct Cap {
  Vec3 offset;
  double level;
};

struct Arc {
  double from, to;
};

/// Latitudes t = cos(theta) at which the circles begin or cease to be cut by a cap.
void add_tangent_latitudes(const Cap& cap, std::vector<double>& latitudes) {
  const double horizontal2 = cap.offset.head<2>().squaredNorm();
  const double d2 = cap.offset.squaredNorm();
  const double z = cap.offset.z();
  const double discriminant =
      cap.level * cap.level * z * z - d2 * (cap.level * cap.level - horizontal2);
  if (d2 == 0.0 || discriminant < 0.0) return;
  const double root = std::sqrt(discriminant);
  latitudes.push_back((cap.level * z - root) / d2);
  latitudes.push_back((cap.level * z + root) / d2);
}

/// Latitudes of the points where the rims of two caps cross.
void add_crossing_latitudes(const Cap& a, const Cap& b, std::vector<double>& latitudes) {
  const double aa = a.offset.squaredNorm();
  const double bb = b.offset.squaredNorm();
  const double ab = a.offset.dot(b.offset);
  const double determinant = aa * bb - ab * ab;
  if (determinant <= 1e-14 * aa * bb) return;
  const Vec3 in_plane =
      ((a.level * bb - b.level * ab) * a.offset + (b.level * aa - a.level * ab) * b.offset) /
      determinant;
  const double rest = 1.0 - in_plane.squaredNorm();
  if (rest < 0.0) return;
  const Vec3 across = a.offset.cross(b.offset) * std::sqrt(rest / determinant);
  latitudes.push_back(in_plane.z() - across.z());
  latitudes.push_back(in_plane.z() + across.z());
}

/// Exposed arcs of the circle of latitude t, within [-pi, pi].
void exposed_arcs(const std::vector<Cap>& caps, double t, std::vector<Arc>& hidden,
                  std::vector<Arc>& exposed) {
  hidden.clear();
  exposed.clear();
  const double radius = std::sqrt(std::max(0.0, 1.0 - t * t));
  for (const Cap& cap : caps) {
    const double horizontal = cap.offset.head<2>().norm() * radius;
    const double needed = cap.level - t * cap.offset.z();
    if (needed <= -horizontal) return;  // the cap hides the whole circle
    if (needed >= horizontal) continue;
    const double middle = std::atan2(cap.offset.y(), cap.offset.x());
    const double half = std::acos(needed / horizontal);
    const Arc arc{middle - half, middle + half};
    if (arc.from < -kPi) {
      hidden.push_back({-kPi, arc.to});
      hidden.push_back({arc.from + 2.0 * kPi, kPi});
    } else if (arc.to > kPi) {
      hidden.push_back({arc.from, kPi});
      hidden.push_back({-kPi, arc.to - 2.0 * kPi});
    } else {
      hidden.push_back(arc);
    }
  }
  std::sort(hidden.begin(), hidden.end(),
            [](const Arc& a, const Arc& b) { return a.from < b.from; });
  double end = -kPi;
  for (const Arc& arc : hidden) {
    if (arc.from > end) exposed.push_back({end, arc.from});
    end = std::max(end, arc.to);
  }
  if (end < kPi) exposed.push_back({end, kPi});
}

/// Fluxes through the exposed part of the ring of latitude t, per unit of t, whose divergences are
/// 1, x, y, ...: each is a field along z, e.g. z e_z for 1 and x z e_z for x.
Moments ring_flux(const Sphere& sphere, double t, const std::vector<Arc>& exposed) {
  double one = 0.0, c = 0.0, s = 0.0, cc = 0.0, ss = 0.0, cs = 0.0;
  for (const Arc& arc : exposed) {
    const double span = arc.to - arc.from;
    const double sin_a = std::sin(arc.from), cos_a = std::cos(arc.from);
    const double sin_b = std::sin(arc.to), cos_b = std::cos(arc.to);
    const double twice = 0.5 * (sin_b * cos_b - sin_a * cos_a);
    one += span;
    c += sin_b - sin_a;
    s += cos_a - cos_b;
    cc += 0.5 * span + twice;
    ss += 0.5 * span - twice;
    cs += 0.5 * (sin_b * sin_b - sin_a * sin_a);
  }
  const double rho = sphere.radius * std::sqrt(std::max(0.0, 1.0 - t * t));
  const double x0 = sphere.position.x(), y0 = sphere.position.y();
  const double z = sphere.position.z() + sphere.radius * t;
  const double x = x0 * one + rho * c;
  const double y = y0 * one + rho * s;
  const double xx = x0 * x0 * one + 2.0 * x0 * rho * c + rho * rho * cc;
  const double yy = y0 * y0 * one + 2.0 * y0 * rho * s + rho * rho * ss;
  const double xy = x0 * y0 * one + rho * (x0 * s + y0 * c) + rho * rho * cs;
  Moments flux;
  flux << z * one, z * x, z * y, 0.5 * z * z * one, z * xx, z * yy, z * z * z / 3.0 * one, z * xy,
      0.5 * z * z * x, 0.5 * z * z * y;
  return flux * (sphere.radius * sphere.radius * t);
}

/// Integral over t in [a, b]; the substitution flattens the square roots at both ends.
Moments integrate_latitudes(const Sphere& sphere, const std::vector<Cap>& caps, double a,
                            double b) {
  std::vector<Arc> hidden, exposed;
  const auto at = [&](double s) {
    const double t = 0.5 * (a + b) + 0.5 * (b - a) * std::sin(0.5 * kPi * s);
    exposed_arcs(caps, t, hidden, exposed);
    return Moments(ring_flux(sphere, t, exposed) *
                   (0.25 * kPi * (b - a) * std::cos(0.5 * kPi * s)));
  };
  Moments sum = Moments::Zero();
  for (int panel = 0; panel < kPanels; ++panel) {
    const double middle = (2.0 * panel + 1.0) / kPanels - 1.0;
    for (std::size_t k = 0; k < Gauss::abscissa().size(); ++k) {
      const double s = Gauss::abscissa()[k] / kPanels;
      sum += Gauss::weights()[k] / kPanels * (at(middle - s) + at(middle + s));
    }
  }
  return sum;
}

Moments sphere_moments(const std::vector<Sphere>& spheres, std::size_t i) {
  const Sphere& sphere = spheres[i];
  std::vector<Cap> caps;
  for (std::size_t j = 0; j < spheres.size(); ++j) {
    if (j == i) continue;
    const Vec3 offset = spheres[j].position - sphere.position;
    const double distance = offset.norm();
    const double other = spheres[j].radius;
    if (distance >= sphere.radius + other) continue;
    const bool equal = distance == 0.0 && other == sphere.radius;
    if (equal ? j < i : distance + sphere.radius <= other) return Moments::Zero();  // inside
    if (equal || distance + other <= sphere.radius) continue;
    caps.push_back({offset, (sphere.radius * sphere.radius + distance * distance - other * other) /
                                (2.0 * sphere.radius)});
  }
  std::vector<double> latitudes{-1.0, 1.0};
  for (std::size_t a = 0; a < caps.size(); ++a) {
    add_tangent_latitudes(caps[a], latitudes);
    for (std::size_t b = 0; b < a; ++b) add_crossing_latitudes(caps[a], caps[b], latitudes);
  }
  std::sort(latitudes.begin(), latitudes.end());
  Moments sum = Moments::Zero();
  double from = -1.0;
  for (double t : latitudes) {
    if (t - from < 1e-14) continue;
    const double to = std::min(t, 1.0);
    sum += integrate_latitudes(sphere, caps, from, to);
    from = to;
  }
  return sum;
}

/// Whether one can go from sphere to sphere through overlaps.
bool hangs_together(const std::vector<Sphere>& spheres) {
  std::vector<std::size_t> reached{0};
  std::vector<bool> seen(spheres.size(), false);
  seen[0] = true;
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (std::size_t j = 0; j < spheres.size(); ++j) {
      const Sphere& a = spheres[reached[k]];
      if (seen[j] || (spheres[j].position - a.position).norm() > a.radius + spheres[j].radius)
        continue;
      seen[j] = true;
      reached.push_back(j);
    }
  return reached.size() == spheres.size();
}

void check(const ClumpShape& shape) {
  const std::string name = "clump \"" + shape.name + "\": ";
  if (shape.spheres.empty()) throw InputError(name + "has no spheres; give one or more");
  for (std::size_t s = 0; s < shape.spheres.size(); ++s) {
    const Sphere& sphere = shape.spheres[s];
    if (!(sphere.radius > 0.0) || !std::isfinite(sphere.radius) || !sphere.position.allFinite())
      throw InputError(name + "sphere " + std::to_string(s + 1) + ": radius = " +
                       shortest(sphere.radius) + ": must be above 0, and its position finite");
  }
  if (!hangs_together(shape.spheres))
    throw InputError(name + "its spheres do not hang together; move them until they overlap");
}

}  // namespace

UnionMoments union_moments(const std::vector<Sphere>& spheres) {
  // About the first sphere, in units of its radius, so that nothing large cancels.
  const Vec3 origin = spheres.front().position;
  const double unit = spheres.front().radius;
  std::vector<Sphere> scaled;
  for (const Sphere& sphere : spheres)
    scaled.push_back({(sphere.position - origin) / unit, sphere.radius / unit});
  Moments m = Moments::Zero();
  for (std::size_t i = 0; i < scaled.size(); ++i) m += sphere_moments(scaled, i);
  UnionMoments result;
  const Vec3 centroid = Vec3(m[1], m[2], m[3]) / m[0];
  Eigen::Matrix3d second;
  second << m[4], m[7], m[8], m[7], m[5], m[9], m[8], m[9], m[6];
  second -= m[0] * centroid * centroid.transpose();
  result.volume = m[0] * unit * unit * unit;
  result.centroid = origin + unit * centroid;
  result.second = second * std::pow(unit, 5);
  return result;
}

ClumpForm clump_form(const ClumpShape& shape) {
  check(shape);
  const UnionMoments moments = union_moments(shape.spheres);
  const double radius = std::cbrt(3.0 * moments.volume / (4.0 * kPi));
  const Eigen::Matrix3d second = moments.second / (moments.volume * radius * radius);
  const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  ClumpForm form;
  form.inertia = solver.eigenvalues();
  form.smallest_radius = shape.spheres.front().radius / radius;
  for (const Sphere& sphere : shape.spheres) {
    const Sphere member{axes.transpose() * (sphere.position - moments.centroid) / radius,
                        sphere.radius / radius};
    form.bounding_radius = std::max(form.bounding_radius, member.position.norm() + member.radius);
    form.smallest_radius = std::min(form.smallest_radius, member.radius);
    form.spheres.push_back(member);
  }
  return form;
}

}  // namespace repose::scene
