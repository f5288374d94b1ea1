// Volume, centre of mass and inertia of a clump: a union of spheres of one density.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "repose/scene/grains.hpp"

namespace repose::scene {

/// A clump scaled to the volume of the unit sphere (so that its volume-equivalent radius is 1) and
/// put into its principal axes: lengths scale with the radius R of a particle, volume with R^3,
/// inertia with m R^2.
struct ClumpForm {
  std::vector<ClumpShape::Sphere> spheres;  ///< from the centre of mass, along principal axes
  Vec3 inertia = Vec3::Zero();              ///< principal moments over m R^2, ascending
  double bounding_radius = 0.0;             ///< of the sphere about the centre that holds all
  double smallest_radius = 0.0;             ///< of the constituent spheres
};

/// Moments of the union of spheres, in the units of the shape.
struct UnionMoments {
  double volume = 0.0;
  Vec3 centroid = Vec3::Zero();
  /// Integral of (x - centroid)(x - centroid)^T over the union, 3 x 3, symmetric.
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// By the divergence theorem over the exposed surface: each sphere is cut into circles of latitude,
/// whose exposed arcs are integrated in closed form; over the latitude a Gauss rule works between
/// the latitudes where arcs appear, vanish or meet. Relative error below 1e-10; the same bits every
/// time. Cost: n^3 for n spheres, n^2 of which only meet where spheres overlap.
UnionMoments union_moments(const std::vector<ClumpShape::Sphere>& spheres);

/// Throws InputError naming the shape if it has no spheres, a radius that is not positive, or parts
/// that do not hang together.
ClumpForm clump_form(const ClumpShape& shape);

}  // namespace repose::scene
