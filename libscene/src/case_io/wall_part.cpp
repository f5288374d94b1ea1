// Walls and their motion in a case file.
#include <cmath>
#include <numbers>

#include "case_io/parts.hpp"
#include "repose/base/error.hpp"

namespace repose::scene {
namespace {

Mesh read_mesh(const TomlTable& table, const Folder& folder) {
  Mesh mesh;
  mesh.file = absolute_from(folder, table.text("file"));
  mesh.scale = table.number_or("scale", mesh.scale, kPositive);
  mesh.translation = vector3_or(table, "translation_m", mesh.translation);
  mesh.open = table.flag_or("open", mesh.open);
  mesh.drop_degenerate = table.flag_or("drop_degenerate", mesh.drop_degenerate);
  mesh.smooth_deg = table.number_or("smooth_deg", mesh.smooth_deg, kNonNegative);
  mesh.content_hash = read_content_hash(table, folder, mesh.file);
  return mesh;
}

Disc read_disc(const TomlTable& table) {
  return {.centre = vector3(table, "centre_m"),
          .normal = vector3(table, "normal"),
          .radius_m = table.number("radius_m", kPositive),
          .inner_radius_m = table.number_or("inner_radius_m", 0.0, kNonNegative)};
}

Cone read_cylinder(const TomlTable& table) {
  const double radius = table.number("radius_m", kPositive);
  return {vector3(table, "start_m"), vector3(table, "end_m"), radius, radius};
}

Cone read_cone(const TomlTable& table) {
  return {vector3(table, "start_m"), vector3(table, "end_m"),
          table.number("start_radius_m", kNonNegative), table.number("end_radius_m", kNonNegative)};
}

Shape read_shape(const TomlTable& table, const Folder& folder) {
  const std::string shape =
      table.choice("shape", {"plane", "rectangle", "disc", "cylinder", "cone", "mesh"});
  if (shape == "plane") return Plane{vector3(table, "origin_m"), vector3(table, "normal")};
  if (shape == "rectangle")
    return Rectangle{vector3(table, "origin_m"), vector3(table, "edge_u_m"),
                     vector3(table, "edge_v_m")};
  if (shape == "disc") return read_disc(table);
  if (shape == "cylinder") return read_cylinder(table);
  if (shape == "cone") return read_cone(table);
  return read_mesh(table, folder);
}

double read_rate(const TomlTable& table) {
  if (!table.has("rate_rpm")) return table.number("rate_rad_s");
  if (table.has("rate_rad_s")) table.fail("rate_rpm", "stands beside rate_rad_s; give one of them");
  return table.number("rate_rpm") * (2.0 * std::numbers::pi / 60.0);
}

TimeTable read_points(const TomlTable& table) {
  TimeTable path;
  for (const TomlTable& point : table.tables("points")) {
    path.times_s.push_back(point.number("time_s"));
    path.displacements_m.push_back(vector3(point, "displacement_m"));
  }
  return path;
}

/// Writes a shape; each overload is one kind.
struct ShapeWriter {
  CaseText& out;
  void operator()(const Plane& plane) const {
    out.put("shape", "plane");
    out.put("origin_m", plane.origin);
    out.put("normal", plane.normal);
  }
  void operator()(const Rectangle& rectangle) const {
    out.put("shape", "rectangle");
    out.put("origin_m", rectangle.origin);
    out.put("edge_u_m", rectangle.edge_u);
    out.put("edge_v_m", rectangle.edge_v);
  }
  void operator()(const Disc& disc) const {
    out.put("shape", "disc");
    out.put("centre_m", disc.centre);
    out.put("normal", disc.normal);
    out.put("radius_m", disc.radius_m);
    out.put("inner_radius_m", disc.inner_radius_m);
  }
  void operator()(const Cone& cone) const {
    const bool is_cylinder = cone.start_radius_m == cone.end_radius_m;
    out.put("shape", is_cylinder ? "cylinder" : "cone");
    out.put("start_m", cone.start);
    out.put("end_m", cone.end);
    if (is_cylinder) {
      out.put("radius_m", cone.start_radius_m);
    } else {
      out.put("start_radius_m", cone.start_radius_m);
      out.put("end_radius_m", cone.end_radius_m);
    }
  }
  void operator()(const Mesh& mesh) const {
    out.put("shape", "mesh");
    out.put("file", mesh.file.string());
    out.put("scale", mesh.scale);
    out.put("translation_m", mesh.translation);
    out.put_flag("open", mesh.open);
    out.put_flag("drop_degenerate", mesh.drop_degenerate);
    out.put("smooth_deg", mesh.smooth_deg);
    out.put_hash(mesh.content_hash);
  }
};

struct PathWriter {
  CaseText& out;
  void operator()(const Translation& path) const {
    out.put("type", "translate");
    out.put("velocity_m_s", path.velocity_m_s);
  }
  void operator()(const Rotation& path) const {
    out.put("type", "rotate");
    out.put("centre_m", path.centre);
    out.put("axis", path.axis);
    out.put("rate_rad_s", path.rate_rad_s);
  }
  void operator()(const Oscillation& path) const {
    out.put("type", "oscillate");
    out.put("amplitude_m", path.amplitude_m);
    out.put("frequency_hz", path.frequency_hz);
    out.put("phase_rad", path.phase_rad);
  }
  void operator()(const TimeTable& path) const {
    out.put("type", "table");
    out.text += "points = [\n";
    for (std::size_t k = 0; k < path.times_s.size(); ++k)
      out.text += "  {time_s = " + number_text(path.times_s[k]) +
                  ", displacement_m = " + vector_text(path.displacements_m.at(k)) + "},\n";
    out.text += "]\n";
  }
};

}  // namespace

Wall read_wall(const TomlTable& table, const Folder& folder) {
  Wall wall;
  wall.name = table.text("name");
  wall.material = table.text("material");
  wall.shape = read_shape(table, folder);
  return wall;
}

std::vector<Wall> read_box(const TomlTable& table) {
  const std::vector<std::string> open = texts_or_none(table, "open");
  const std::string name = table.text("name");
  const std::string material = table.text("material");
  const Vec3 lower = vector3(table, "lower_m");
  const Vec3 upper = vector3(table, "upper_m");
  try {
    return box_walls(name, material, lower, upper, open);
  } catch (const InputError& error) {
    table.fail("open", error.what());
  }
}

Motion read_motion(const TomlTable& table) {
  Motion motion;
  motion.walls = table.texts("walls");
  const std::string type = table.choice("type", {"translate", "rotate", "oscillate", "table"});
  if (type == "translate")
    motion.path = Translation{vector3(table, "velocity_m_s")};
  else if (type == "rotate")
    motion.path = Rotation{vector3(table, "centre_m"), vector3(table, "axis"), read_rate(table)};
  else if (type == "oscillate")
    motion.path =
        Oscillation{vector3(table, "amplitude_m"), table.number("frequency_hz", kPositive),
                    table.number_or("phase_rad", 0.0)};
  else
    motion.path = read_points(table);
  motion.stage = table.text_or("stage", "");
  motion.start_s = table.number_or("start_s", motion.start_s, kNonNegative);
  motion.end_s = table.number_or("end_s", motion.end_s, kPositive);
  return motion;
}

void write_wall(CaseText& out, const Wall& wall) {
  out.heading("[[wall]]");
  out.put("name", wall.name);
  out.put("material", wall.material);
  std::visit(ShapeWriter{out}, wall.shape);
}

void write_motion(CaseText& out, const Motion& motion) {
  out.heading("[[motion]]");
  out.put("walls", motion.walls);
  std::visit(PathWriter{out}, motion.path);
  out.put_if_any("stage", motion.stage);
  out.put("start_s", motion.start_s);
  if (std::isfinite(motion.end_s)) out.put("end_s", motion.end_s);
}

}  // namespace repose::scene
