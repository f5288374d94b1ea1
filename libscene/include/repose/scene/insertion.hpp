// How particles come into a simulation.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "repose/scene/grains.hpp"

namespace repose::scene {

/// Particles poured as one layer, kinds mixed at random.
struct Layer {
  double mass_kg = 0.0;
  std::vector<Grains> mixture{};  ///< mass fractions sum to 1
  bool operator==(const Layer&) const = default;
};

/// Layers placed over each other by random sequential addition in the column of `lower`-`upper`,
/// without overlap among themselves and with walls; nothing is placed above upper.z. Clumps are
/// turned at random, every orientation alike.
struct Fill {
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  double solid_fraction = 0.33;  ///< of the loose column, before it falls; at most 0.36
  std::vector<Layer> layers{};   ///< bottom first
  bool operator==(const Fill&) const = default;
};

/// Particles that appear in a box at a rate, at random free places, until the mass is in. What
/// finds no place waits; a backlog of more than a second's rate, or mass that is not in when the
/// last stage ends, is an error.
struct Rain {
  std::string name{};
  std::vector<Grains> mixture{};
  double mass_kg = 0.0;
  double mass_rate_kg_s = 0.0;
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();  ///< m/s, of every particle
  std::string stage{};  ///< start_s counts from its beginning; from that of the run if empty
  double start_s = 0.0;
  bool operator==(const Rain&) const = default;
};

/// Particles from a table: columns x_m, y_m, z_m, radius_m and, where present, material (a name, or
/// an index into the table's attribute `materials`), clump, vx_m_s ..., wx_rad_s ..., qw, qx, qy,
/// qz. An HDF5 table, e.g. a snapshot RUN.h5:/snapshots/000002, or CSV with a header line.
struct ParticleTable {
  std::string location{};  ///< FILE.h5:/group or FILE.csv; relative to the folder of the case file
  std::string material{};  ///< of particles of a table without a column material
  std::string clump{};     ///< of particles of a table without a column clump; empty for spheres
  std::uint64_t content_hash = 0;  ///< of the file's bytes, FNV-1a, 0 if unknown
  bool operator==(const ParticleTable&) const = default;
};

/// A particle placed by hand.
struct Particle {
  std::string material{};
  Vec3 position = Vec3::Zero();          ///< m; of the centre of mass
  Vec3 velocity = Vec3::Zero();          ///< m/s
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s
  double radius_m = 0.0;                 ///< of a clump: of the sphere of its volume
  std::string clump{};                   ///< name of a ClumpShape; empty for a sphere
  /// Turns a clump from its principal axes, smallest moment of inertia first, into the world.
  std::array<double, 4> orientation_wxyz{1.0, 0.0, 0.0, 0.0};  ///< unit quaternion
  bool operator==(const Particle&) const = default;
};

}  // namespace repose::scene
