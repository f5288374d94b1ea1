// Reading and writing of case files.
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/base/toml.hpp"
#include "repose/scene/case.hpp"

namespace repose::scene {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3 vector3(const TomlTable& table, const char* key) {
  const std::vector<double> values = table.numbers(key);
  if (values.size() != 3)
    table.fail(key, "has " + std::to_string(values.size()) + " numbers; give three, [x, y, z]");
  return {values[0], values[1], values[2]};
}

Vec3 vector3_or(const TomlTable& table, const char* key, const Vec3& fallback) {
  return table.has(key) ? vector3(table, key) : fallback;
}

Material read_material(const TomlTable& table) {
  Material material;
  material.name = table.text("name");
  material.density_kg_m3 = table.number("density_kg_m3", kPositive);
  material.poissons_ratio = table.number(
      "poissons_ratio", {.lower = -1.0, .upper = 0.5, .open_lower = true, .open_upper = false});
  if (table.has("shear_modulus_pa")) {
    if (table.has("youngs_modulus_pa"))
      table.fail("shear_modulus_pa", "stands beside youngs_modulus_pa; give one of them");
    material.youngs_modulus_pa =
        2.0 * table.number("shear_modulus_pa", kPositive) * (1.0 + material.poissons_ratio);
  } else {
    material.youngs_modulus_pa = table.number("youngs_modulus_pa", kPositive);
  }
  return material;
}

PairCoefficients read_pair(const TomlTable& table) {
  PairCoefficients pair;
  const std::vector<std::string> names = table.texts("materials");
  if (names.size() != 2)
    table.fail("materials",
               "has " + std::to_string(names.size()) + " names; give two, [\"a\", \"b\"]");
  pair.first = names[0];
  pair.second = names[1];
  pair.restitution = table.number("restitution", {.lower = 0.0, .upper = 1.0, .open_lower = true});
  pair.mu_s = table.number("mu_s", kNonNegative);
  pair.mu_r = table.number("mu_r", kNonNegative);
  pair.rolling_damping = table.number_or("rolling_damping", pair.rolling_damping, kNonNegative);
  return pair;
}

Wall read_wall(const TomlTable& table) {
  Wall wall;
  wall.name = table.text("name");
  wall.material = table.text("material");
  const Vec3 origin = vector3(table, "origin_m");
  if (table.choice("shape", {"plane", "rectangle"}) == "plane")
    wall.shape = Plane{origin, vector3(table, "normal")};
  else
    wall.shape = Rectangle{origin, vector3(table, "edge_u_m"), vector3(table, "edge_v_m")};
  return wall;
}

std::vector<Wall> read_box(const TomlTable& table) {
  const std::vector<std::string> open =
      table.has("open") ? table.texts("open") : std::vector<std::string>{};
  return box_walls(table.text("name"), table.text("material"), vector3(table, "lower_m"),
                   vector3(table, "upper_m"), open);
}

/// A region gives only the bounds that it has: x_m = [lower, upper] or x_above_m, x_below_m.
Region read_region(const TomlTable& table) {
  Region region;
  region.name = table.text("name");
  region.lower.setConstant(-kInfinity);
  region.upper.setConstant(kInfinity);
  if (table.has("lower_m")) region.lower = vector3(table, "lower_m");
  if (table.has("upper_m")) region.upper = vector3(table, "upper_m");
  const char* const axes[3] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    const std::string above = std::string(axes[k]) + "_above_m";
    const std::string below = std::string(axes[k]) + "_below_m";
    if (table.has(above)) region.lower[k] = table.number(above);
    if (table.has(below)) region.upper[k] = table.number(below);
  }
  return region;
}

SizeClass read_size(const TomlTable& table) {
  SizeClass size;
  if (table.has("diameter_m")) {
    size.lower_diameter_m = table.number("diameter_m", kPositive);
    size.upper_diameter_m = size.lower_diameter_m;
  } else {
    size.lower_diameter_m = table.number("lower_diameter_m", kPositive);
    size.upper_diameter_m = table.number("upper_diameter_m", kPositive);
  }
  size.mass_fraction =
      table.number_or("mass_fraction", 1.0, {.lower = 0.0, .upper = 1.0, .open_lower = true});
  return size;
}

Fill read_fill(const TomlTable& table) {
  Fill fill;
  fill.lower = vector3(table, "lower_m");
  fill.upper = vector3(table, "upper_m");
  fill.solid_fraction = table.number_or("solid_fraction", fill.solid_fraction, kPositive);
  for (const TomlTable& item : table.tables("layer")) {
    Layer layer;
    layer.mass_kg = item.number("mass_kg", kPositive);
    std::vector<SizeClass> sizes;
    for (const TomlTable& size : item.tables("sizes")) sizes.push_back(read_size(size));
    layer.mixture = {{.material = item.text("material"), .sizes = sizes}};
    fill.layers.push_back(layer);
  }
  return fill;
}

Particle read_particle(const TomlTable& table) {
  Particle particle;
  particle.material = table.text("material");
  particle.radius_m = table.number("radius_m", kPositive);
  particle.position = vector3(table, "position_m");
  particle.velocity = vector3_or(table, "velocity_m_s", Vec3::Zero());
  particle.angular_velocity = vector3_or(table, "angular_velocity_rad_s", Vec3::Zero());
  return particle;
}

Stage read_stage(const TomlTable& table) {
  Stage stage;
  stage.name = table.text("name");
  if (table.has("opens")) stage.opens = table.texts("opens");
  stage.duration_s = table.number("duration_s", kPositive);
  stage.minimum_s = table.number_or("minimum_s", 0.0, kNonNegative);
  if (const auto rest = table.table_if_present("at_rest")) {
    AtRest criterion;
    criterion.kinetic_energy_ratio =
        rest->number_or("kinetic_energy_ratio", criterion.kinetic_energy_ratio, kPositive);
    criterion.window_s = rest->number_or("window_s", criterion.window_s, kPositive);
    stage.at_rest = criterion;
  }
  if (const auto ends = table.table_if_present("flow_ends")) {
    FlowEnds criterion;
    criterion.region = ends->text("region");
    criterion.fraction = ends->number_or("fraction", criterion.fraction, kPositive);
    criterion.window_s = ends->number_or("window_s", criterion.window_s, kPositive);
    stage.flow_ends = criterion;
  }
  return stage;
}

void read_domain(const TomlTable& table, Case& scene) {
  scene.lower_m = vector3(table, "lower_m");
  scene.upper_m = vector3(table, "upper_m");
  if (!table.has("periodic")) return;
  for (const std::string& axis : table.texts("periodic")) {
    if (axis == "x")
      scene.periodic.x = true;
    else if (axis == "y")
      scene.periodic.y = true;
    else if (axis == "z")
      scene.periodic.z = true;
    else
      table.fail("periodic", "\"" + axis + "\" is not a direction; name \"x\", \"y\" or \"z\"");
  }
}

Case case_of(const TomlTable& root) {
  Case scene;
  if (const auto run = root.table_if_present("run")) {
    scene.seed = static_cast<std::uint64_t>(run->integer_or("seed", 1, kNonNegative));
    scene.time_step_rayleigh_fraction =
        run->number_or("time_step_rayleigh_fraction", scene.time_step_rayleigh_fraction, kPositive);
  }
  scene.gravity_m_s2 = vector3_or(root, "gravity_m_s2", scene.gravity_m_s2);
  read_domain(root.table("domain"), scene);
  for (const TomlTable& table : root.tables("material"))
    scene.materials.push_back(read_material(table));
  for (const TomlTable& table : root.tables("pair")) scene.pairs.push_back(read_pair(table));
  for (const TomlTable& table : root.tables("wall")) scene.walls.push_back(read_wall(table));
  for (const TomlTable& table : root.tables("box"))
    for (const Wall& wall : read_box(table)) scene.walls.push_back(wall);
  for (const TomlTable& table : root.tables("region")) scene.regions.push_back(read_region(table));
  if (const auto fill = root.table_if_present("fill")) scene.fill = read_fill(*fill);
  for (const TomlTable& table : root.tables("particle"))
    scene.particles.push_back(read_particle(table));
  for (const TomlTable& table : root.tables("stage")) scene.stages.push_back(read_stage(table));
  if (const auto output = root.table_if_present("output")) {
    scene.output.snapshot_interval_s =
        output->number_or("snapshot_interval_s", scene.output.snapshot_interval_s, kNonNegative);
    scene.output.series_interval_s =
        output->number_or("series_interval_s", scene.output.series_interval_s, kPositive);
  }
  root.refuse_unknown_keys();
  try {
    validate(scene);
  } catch (const InputError& error) {
    throw InputError(root.file() + ": " + error.what());
  }
  return scene;
}

/// A TOML float, so that -0.0 and whole numbers keep type and bits.
std::string number(double value) {
  std::string text = shortest(value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string vector_text(const Vec3& v) {
  return "[" + number(v.x()) + ", " + number(v.y()) + ", " + number(v.z()) + "]";
}

std::string names_text(const std::vector<std::string>& names) {
  std::string text = "[";
  for (std::size_t n = 0; n < names.size(); ++n)
    text += (n == 0 ? "" : ", ") + toml_quoted(names[n]);
  return text + "]";
}

/// Collects the lines of a file.
struct Writer {
  std::string text;
  void heading(const std::string& name) { text += "\n" + name + "\n"; }
  void raw(const std::string& key, const std::string& value) { text += key + " = " + value + "\n"; }
  void put(const std::string& key, double value) { raw(key, number(value)); }
  void put(const std::string& key, const std::string& value) { raw(key, toml_quoted(value)); }
  void put(const std::string& key, const Vec3& value) { raw(key, vector_text(value)); }
  void put(const std::string& key, const std::vector<std::string>& value) {
    raw(key, names_text(value));
  }
};

void write_head(Writer& out, const Case& scene) {
  out.put("gravity_m_s2", scene.gravity_m_s2);
  out.heading("[run]");
  out.raw("seed", std::to_string(scene.seed));
  out.put("time_step_rayleigh_fraction", scene.time_step_rayleigh_fraction);
  out.heading("[domain]");
  out.put("lower_m", scene.lower_m);
  out.put("upper_m", scene.upper_m);
  std::vector<std::string> periodic;
  if (scene.periodic.x) periodic.push_back("x");
  if (scene.periodic.y) periodic.push_back("y");
  if (scene.periodic.z) periodic.push_back("z");
  out.put("periodic", periodic);
  for (const Material& material : scene.materials) {
    out.heading("[[material]]");
    out.put("name", material.name);
    out.put("density_kg_m3", material.density_kg_m3);
    out.put("youngs_modulus_pa", material.youngs_modulus_pa);
    out.put("poissons_ratio", material.poissons_ratio);
  }
  for (const PairCoefficients& pair : scene.pairs) {
    out.heading("[[pair]]");
    out.put("materials", std::vector<std::string>{pair.first, pair.second});
    out.put("restitution", pair.restitution);
    out.put("mu_s", pair.mu_s);
    out.put("mu_r", pair.mu_r);
    out.put("rolling_damping", pair.rolling_damping);
  }
}

void write_geometry(Writer& out, const Case& scene) {
  for (const Wall& wall : scene.walls) {
    out.heading("[[wall]]");
    out.put("name", wall.name);
    out.put("material", wall.material);
    if (const auto* plane = std::get_if<Plane>(&wall.shape)) {
      out.put("shape", std::string("plane"));
      out.put("origin_m", plane->origin);
      out.put("normal", plane->normal);
    } else {
      const auto& rectangle = std::get<Rectangle>(wall.shape);
      out.put("shape", std::string("rectangle"));
      out.put("origin_m", rectangle.origin);
      out.put("edge_u_m", rectangle.edge_u);
      out.put("edge_v_m", rectangle.edge_v);
    }
  }
  const char* const axes[3] = {"x", "y", "z"};
  for (const Region& region : scene.regions) {
    out.heading("[[region]]");
    out.put("name", region.name);
    for (int k = 0; k < 3; ++k) {
      if (std::isfinite(region.lower[k]))
        out.put(std::string(axes[k]) + "_above_m", region.lower[k]);
      if (std::isfinite(region.upper[k]))
        out.put(std::string(axes[k]) + "_below_m", region.upper[k]);
    }
  }
}

void write_particles(Writer& out, const Case& scene) {
  if (scene.fill) {
    out.heading("[fill]");
    out.put("lower_m", scene.fill->lower);
    out.put("upper_m", scene.fill->upper);
    out.put("solid_fraction", scene.fill->solid_fraction);
    for (const Layer& layer : scene.fill->layers) {
      out.heading("[[fill.layer]]");
      out.put("material", layer.mixture.front().material);
      out.put("mass_kg", layer.mass_kg);
      out.text += "sizes = [\n";
      for (const SizeClass& size : size_classes(layer.mixture.front().sizes))
        out.text += "  {lower_diameter_m = " + number(size.lower_diameter_m) +
                    ", upper_diameter_m = " + number(size.upper_diameter_m) +
                    ", mass_fraction = " + number(size.mass_fraction) + "},\n";
      out.text += "]\n";
    }
  }
  for (const Particle& particle : scene.particles) {
    out.heading("[[particle]]");
    out.put("material", particle.material);
    out.put("radius_m", particle.radius_m);
    out.put("position_m", particle.position);
    out.put("velocity_m_s", particle.velocity);
    out.put("angular_velocity_rad_s", particle.angular_velocity);
  }
}

void write_stages(Writer& out, const Case& scene) {
  for (const Stage& stage : scene.stages) {
    out.heading("[[stage]]");
    out.put("name", stage.name);
    out.put("opens", stage.opens);
    out.put("duration_s", stage.duration_s);
    out.put("minimum_s", stage.minimum_s);
    if (stage.at_rest)
      out.raw("at_rest", "{kinetic_energy_ratio = " + number(stage.at_rest->kinetic_energy_ratio) +
                             ", window_s = " + number(stage.at_rest->window_s) + "}");
    if (stage.flow_ends)
      out.raw("flow_ends", "{region = " + toml_quoted(stage.flow_ends->region) +
                               ", fraction = " + number(stage.flow_ends->fraction) +
                               ", window_s = " + number(stage.flow_ends->window_s) + "}");
  }
  out.heading("[output]");
  out.put("snapshot_interval_s", scene.output.snapshot_interval_s);
  out.put("series_interval_s", scene.output.series_interval_s);
}

}  // namespace

Case read_case(const std::filesystem::path& path) {
  return case_of(TomlTable::read_file(path));
}

Case parse_case(std::string_view text, const std::string& name) {
  return case_of(TomlTable::parse(text, name));
}

std::string case_text(const Case& scene) {
  Writer out;
  out.text = "# A case of repose-dem.\n";
  write_head(out, scene);
  write_geometry(out, scene);
  write_particles(out, scene);
  write_stages(out, scene);
  return out.text;
}

void write_case(const std::filesystem::path& path, const Case& scene) {
  write_file_atomically(path, case_text(scene));
}

}  // namespace repose::scene
