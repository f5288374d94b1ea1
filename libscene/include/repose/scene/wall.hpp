// Walls: their shapes and how they move.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace repose::scene {

using Vec3 = Eigen::Vector3d;

/// The half-space that the normal points into, which is where the particles are.
struct Plane {
  Vec3 origin = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< any length
  bool operator==(const Plane&) const = default;
};

/// origin + a u + b v with a, b in [0, 1]; pushes on both of its sides, as all that follow do.
struct Rectangle {
  Vec3 origin = Vec3::Zero();
  Vec3 edge_u = Vec3::Zero();
  Vec3 edge_v = Vec3::Zero();  ///< perpendicular to edge_u
  bool operator==(const Rectangle&) const = default;
};

/// A flat disc, or a ring if it has an inner radius.
struct Disc {
  Vec3 centre = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< any length
  double radius_m = 0.0;
  double inner_radius_m = 0.0;
  bool operator==(const Disc&) const = default;
};

/// The side of a cylinder, a cone or a frustum; its ends are open.
struct Cone {
  Vec3 start = Vec3::Zero();
  Vec3 end = Vec3::Zero();
  double start_radius_m = 0.0;
  double end_radius_m = 0.0;  ///< equal to start_radius_m for a cylinder
  bool operator==(const Cone&) const = default;
};

/// Triangles from an STL file, ASCII or binary. Corners are welded within 1e-6 of the bounding box.
struct Mesh {
  std::filesystem::path file{};     ///< a case file's relative path is taken from its own folder
  double scale = 1.0;               ///< 0.001 for a file in millimetres
  Vec3 translation = Vec3::Zero();  ///< m, after scaling
  bool open = false;                ///< a surface that has a rim; without it a rim is an error
  bool drop_degenerate = false;     ///< leave triangles without area, or the same as an earlier
                                    ///< one, out; without it they are an error
  double smooth_deg = 5.0;          ///< facets that meet at a smaller angle are one smooth surface
  /// Of the file's bytes, FNV-1a, 0 if unknown: a mesh that changed since is refused.
  std::uint64_t content_hash = 0;
  bool operator==(const Mesh&) const = default;
};

using Shape = std::variant<Plane, Rectangle, Disc, Cone, Mesh>;

struct Wall {
  std::string name{};
  std::string material{};
  Shape shape{};
  bool operator==(const Wall&) const = default;
};

/// Constant velocity.
struct Translation {
  Vec3 velocity_m_s = Vec3::Zero();
  bool operator==(const Translation&) const = default;
};
/// Constant rate about an axis.
struct Rotation {
  Vec3 centre = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  ///< any length
  double rate_rad_s = 0.0;
  bool operator==(const Rotation&) const = default;
};
/// Displacement amplitude * (sin(2 pi f t + phase) - sin(phase)).
struct Oscillation {
  Vec3 amplitude_m = Vec3::Zero();
  double frequency_hz = 0.0;
  double phase_rad = 0.0;
  bool operator==(const Oscillation&) const = default;
};
/// Displacements at given times, linear in between, held before the first and after the last.
struct TimeTable {
  std::vector<double> times_s{};        ///< ascending
  std::vector<Vec3> displacements_m{};  ///< first 0 unless the motion starts with the run
  bool operator==(const TimeTable&) const = default;
};

/// A prescribed movement of walls, evaluated from the time and never accumulated. It runs from
/// start_s to end_s, both counted from the beginning of `stage` (of the run, if none is named);
/// before, the wall is where it was drawn, afterwards it stays. Several movements of one wall are
/// carried out in the order of the file, each on the result of the one before.
struct Motion {
  std::vector<std::string> walls{};  ///< names; the name of a box means all of its faces
  std::variant<Translation, Rotation, Oscillation, TimeTable> path{};
  std::string stage{};
  double start_s = 0.0;
  double end_s = std::numeric_limits<double>::infinity();
  bool operator==(const Motion&) const = default;
};

/// The six faces of an axis-parallel box as rectangles named NAME.-x, NAME.+x, ... NAME.+z, without
/// those listed in `open` ("-x", "+z", ...). What `[[box]]` of a case file expands to.
std::vector<Wall> box_walls(const std::string& name, const std::string& material, const Vec3& lower,
                            const Vec3& upper, const std::vector<std::string>& open);

}  // namespace repose::scene
