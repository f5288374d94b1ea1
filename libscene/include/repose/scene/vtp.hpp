// Snapshots for ParaView: VTK XML PolyData files (.vtp) and the index of their times (.pvd).
//
// FOLDER/particles_000001.vtp ... are points with the data radius, mass, material, velocity,
// angular_velocity, body and id, listed in FOLDER/particles.pvd; FOLDER/walls_000001.vtp ... are
// triangles with the data wall and material (indices into the case), a new one each time that walls
// have moved or were taken away, listed in FOLDER/walls.pvd. Arrays stand appended raw, little
// endian, with 64-bit lengths; reals have single precision.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "repose/scene/case.hpp"
#include "repose/scene/run_records.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::scene {

/// The wall as triangles where it was drawn: a plane as far as the domain reaches, round shapes in
/// 64 facets, a mesh as load_mesh() gives it. Throws as load_mesh().
TriangleMesh wall_triangles(const Case& scene, const Wall& wall);

/// Triangles of several walls.
struct WallPicture {
  TriangleMesh mesh;
  std::vector<std::int32_t> wall;      ///< of each triangle, index into Case::walls
  std::vector<std::int32_t> material;  ///< of each triangle, index into Case::materials
};

/// The content of a .vtp file.
std::string vtp_text(const Snapshot& snapshot);
std::string vtp_text(const WallPicture& walls, double time_s);

/// Writes the files of a run as it goes.
class VtpWriter {
 public:
  /// Creates the folder. Throws StorageError, and as wall_triangles().
  VtpWriter(std::filesystem::path folder, const Case& scene);
  /// Writes the particles, the walls if `poses` differ from those before (empty: as drawn), and the
  /// indices. Throws StorageError.
  void write(const Snapshot& snapshot, const std::vector<WallPose>& poses);
  /// Goes on after the snapshots of an earlier run, which had these times and the last of them
  /// these poses; removes files that follow. Throws StorageError if one is missing.
  void go_on_after(const std::vector<double>& times_s, const std::vector<WallPose>& poses);
  /// Of the last snapshot.
  const std::vector<WallPose>& poses() const { return poses_; }

 private:
  WallPicture picture(const std::vector<WallPose>& poses) const;
  void write_indices() const;
  void remove_files_after(std::size_t number) const;
  void write_index(const char* name, const std::vector<std::string>& files) const;

  std::filesystem::path folder_;
  std::vector<TriangleMesh> walls_;  // as drawn
  std::vector<std::int32_t> materials_;
  std::vector<WallPose> poses_;  // last written
  std::vector<double> times_s_;
  std::vector<std::string> particle_files_, wall_files_;  // one a time
};

}  // namespace repose::scene
