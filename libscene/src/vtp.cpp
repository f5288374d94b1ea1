#include "repose/scene/vtp.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <utility>

#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "run_parts.hpp"

namespace repose::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they stand");

template <class T>
const char* type_name();
template <>
const char* type_name<float>() {
  return "Float32";
}
template <>
const char* type_name<std::int32_t>() {
  return "Int32";
}
template <>
const char* type_name<std::int64_t>() {
  return "Int64";
}

/// Gathers a file: its XML and the bytes that are appended to it.
class PolyData {
 public:
  PolyData(std::size_t points, std::size_t vertices, std::size_t polygons, double time_s) {
    xml_ = fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<PolyData>\n"
        "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
        "format=\"ascii\">{}</DataArray></FieldData>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" "
        "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        shortest(time_s), points, vertices, polygons);
  }

  void begin(const char* section) { xml_ += fmt::format("<{}>\n", section); }
  void end(const char* section) { xml_ += fmt::format("</{}>\n", section); }

  template <class T>
  void array(const char* name, const std::vector<T>& values, int components = 1) {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
        "offset=\"{}\"/>\n",
        type_name<T>(), name, components, bytes_.size());
    const std::uint64_t size = values.size() * sizeof(T);
    append(&size, sizeof size);
    append(values.data(), size);
  }
  void array(const char* name, const std::vector<double>& values) {
    array(name, std::vector<float>(values.begin(), values.end()));
  }
  void array(const char* name, const std::vector<Vec3>& vectors) {
    std::vector<float> values;
    values.reserve(3 * vectors.size());
    for (const Vec3& v : vectors)
      for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(v[k]));
    array(name, values, 3);
  }
  /// Cells of `corners` points each.
  void cells(const char* section, const std::vector<std::int64_t>& points, std::int64_t corners) {
    std::vector<std::int64_t> ends;
    for (std::int64_t k = corners; k <= static_cast<std::int64_t>(points.size()); k += corners)
      ends.push_back(k);
    begin(section);
    array("connectivity", points);
    array("offsets", ends);
    end(section);
  }

  std::string text() const {
    return xml_ + "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + bytes_ +
           "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  void append(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  std::string xml_;
  std::string bytes_;
};

std::string particles_file(std::size_t number) {
  return fmt::format("particles_{:06}.vtp", number);
}

std::string walls_file(std::size_t number) {
  return fmt::format("walls_{:06}.vtp", number);
}

WallPose pose_of(const std::vector<WallPose>& poses, std::size_t wall) {
  return poses.empty() ? WallPose{} : poses.at(wall);
}

void add(WallPicture& picture, const TriangleMesh& mesh, const WallPose& pose) {
  const auto first = static_cast<std::int32_t>(picture.mesh.corners.size());
  for (const Vec3& corner : mesh.corners)
    picture.mesh.corners.push_back(pose.rotation * corner + pose.translation);
  for (const std::array<std::int32_t, 3>& triangle : mesh.triangles)
    picture.mesh.triangles.push_back(
        {first + triangle[0], first + triangle[1], first + triangle[2]});
}

}  // namespace

std::string vtp_text(const Snapshot& s) {
  PolyData file(s.size(), s.size(), 0, s.time_s);
  file.begin("PointData");
  file.array("radius", s.radius_m);
  file.array("mass", s.mass_kg);
  file.array("material", s.material);
  file.array("velocity", s.velocity);
  file.array("angular_velocity", s.angular_velocity);
  file.array("body", s.body);
  file.array("id", s.id);
  file.end("PointData");
  file.begin("Points");
  file.array("Points", s.position);
  file.end("Points");
  std::vector<std::int64_t> points;
  for (std::size_t i = 0; i < s.size(); ++i) points.push_back(static_cast<std::int64_t>(i));
  file.cells("Verts", points, 1);
  return file.text();
}

std::string vtp_text(const WallPicture& walls, double time_s) {
  const TriangleMesh& mesh = walls.mesh;
  PolyData file(mesh.corners.size(), 0, mesh.triangles.size(), time_s);
  file.begin("CellData");
  file.array("wall", walls.wall);
  file.array("material", walls.material);
  file.end("CellData");
  file.begin("Points");
  file.array("Points", mesh.corners);
  file.end("Points");
  std::vector<std::int64_t> points;
  for (const std::array<std::int32_t, 3>& triangle : mesh.triangles)
    points.insert(points.end(), triangle.begin(), triangle.end());
  file.cells("Polys", points, 3);
  return file.text();
}

VtpWriter::VtpWriter(std::filesystem::path folder, const Case& scene) : folder_(std::move(folder)) {
  for (const Wall& wall : scene.walls) {
    walls_.push_back(wall_triangles(scene, wall));
    materials_.push_back(material_index(scene, wall.material));
  }
  make_directory(folder_);
}

WallPicture VtpWriter::picture(const std::vector<WallPose>& poses) const {
  WallPicture all;
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const WallPose pose = pose_of(poses, w);
    if (pose.is_open) continue;
    add(all, walls_[w], pose);
    all.wall.resize(all.mesh.triangles.size(), static_cast<std::int32_t>(w));
    all.material.resize(all.mesh.triangles.size(), materials_[w]);
  }
  return all;
}

void VtpWriter::write_indices() const {
  write_index("particles.pvd", particle_files_);
  write_index("walls.pvd", wall_files_);
}

void VtpWriter::write_index(const char* name, const std::vector<std::string>& files) const {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<Collection>\n";
  for (std::size_t k = 0; k < files.size(); ++k)
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n",
                        shortest(times_s_[k]), files[k]);
  write_file_atomically(folder_ / name, text + "</Collection>\n</VTKFile>\n");
}

void VtpWriter::write(const Snapshot& snapshot, const std::vector<WallPose>& poses) {
  const std::size_t number = times_s_.size() + 1;
  const std::string particles = particles_file(number);
  write_file_atomically(folder_ / particles, vtp_text(snapshot));
  const bool is_first = wall_files_.empty();
  std::string walls = is_first ? "" : wall_files_.back();
  if (is_first || poses != poses_) {
    walls = walls_file(number);
    write_file_atomically(folder_ / walls, vtp_text(picture(poses), snapshot.time_s));
    poses_ = poses;
  }
  times_s_.push_back(snapshot.time_s);
  particle_files_.push_back(particles);
  wall_files_.push_back(walls);
  write_indices();
}

void VtpWriter::remove_files_after(std::size_t number) const {
  std::size_t last = number;
  while (std::filesystem::exists(folder_ / particles_file(last + 1))) ++last;
  // The last first, walls before particles: who is killed here finds the rest the next time.
  for (; last > number; --last) {
    remove_part(folder_ / walls_file(last));
    remove_part(folder_ / particles_file(last));
  }
}

void VtpWriter::go_on_after(const std::vector<double>& times_s,
                            const std::vector<WallPose>& poses) {
  times_s_ = times_s;
  poses_ = poses;
  for (std::size_t number = 1; number <= times_s.size(); ++number) {
    particle_files_.push_back(particles_file(number));
    require_part(folder_ / particle_files_.back());
    const std::string walls = walls_file(number);
    const bool is_new = std::filesystem::exists(folder_ / walls);
    if (number == 1) require_part(folder_ / walls);
    wall_files_.push_back(is_new ? walls : wall_files_.back());
  }
  remove_files_after(times_s.size());
  if (!times_s.empty()) write_indices();
}

}  // namespace repose::scene
