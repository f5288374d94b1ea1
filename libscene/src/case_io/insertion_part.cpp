// Fill, rain, particle tables and particles in a case file.
#include "case_io/parts.hpp"
#include "repose/base/error.hpp"
#include "repose/table/io.hpp"

namespace repose::scene {
namespace {

void write_fill(CaseText& out, const Fill& fill) {
  out.heading("[fill]");
  out.put("lower_m", fill.lower);
  out.put("upper_m", fill.upper);
  out.put("solid_fraction", fill.solid_fraction);
  for (const Layer& layer : fill.layers) {
    out.heading("[[fill.layer]]");
    out.put("mass_kg", layer.mass_kg);
    write_mixture(out, layer.mixture, "[[fill.layer.mixture]]");
  }
}

void write_rain(CaseText& out, const Rain& rain) {
  out.heading("[[rain]]");
  out.put("name", rain.name);
  out.put("mass_kg", rain.mass_kg);
  out.put("mass_rate_kg_s", rain.mass_rate_kg_s);
  out.put("lower_m", rain.lower);
  out.put("upper_m", rain.upper);
  out.put("velocity_m_s", rain.velocity);
  out.put_if_any("stage", rain.stage);
  out.put("start_s", rain.start_s);
  write_mixture(out, rain.mixture, "[[rain.mixture]]");
}

void write_particle_table(CaseText& out, const ParticleTable& particles) {
  out.heading("[[particle_table]]");
  out.put("file", particles.location);
  out.put_if_any("material", particles.material);
  out.put_if_any("clump", particles.clump);
  out.put_hash(particles.content_hash);
}

void write_particle(CaseText& out, const Particle& particle) {
  out.heading("[[particle]]");
  out.put("material", particle.material);
  out.put_if_any("clump", particle.clump);
  out.put("radius_m", particle.radius_m);
  out.put("position_m", particle.position);
  out.put("velocity_m_s", particle.velocity);
  out.put("angular_velocity_rad_s", particle.angular_velocity);
  const auto& q = particle.orientation_wxyz;
  out.raw("orientation_wxyz", "[" + number_text(q[0]) + ", " + number_text(q[1]) + ", " +
                                  number_text(q[2]) + ", " + number_text(q[3]) + "]");
}

std::array<double, 4> read_orientation(const TomlTable& table) {
  if (!table.has("orientation_wxyz")) return Particle{}.orientation_wxyz;
  const std::vector<double> q = table.numbers("orientation_wxyz");
  if (q.size() != 4)
    table.fail("orientation_wxyz",
               "has " + std::to_string(q.size()) + " numbers; give four, [w, x, y, z]");
  return {q[0], q[1], q[2], q[3]};
}

}  // namespace

Fill read_fill(const TomlTable& table) {
  Fill fill;
  fill.lower = vector3(table, "lower_m");
  fill.upper = vector3(table, "upper_m");
  fill.solid_fraction = table.number_or("solid_fraction", fill.solid_fraction, kPositive);
  for (const TomlTable& item : table.tables("layer"))
    fill.layers.push_back({item.number("mass_kg", kPositive), read_mixture(item)});
  return fill;
}

Rain read_rain(const TomlTable& table) {
  Rain rain;
  rain.name = table.text("name");
  rain.mixture = read_mixture(table);
  rain.mass_kg = table.number("mass_kg", kPositive);
  rain.mass_rate_kg_s = table.number("mass_rate_kg_s", kPositive);
  rain.lower = vector3(table, "lower_m");
  rain.upper = vector3(table, "upper_m");
  rain.velocity = vector3_or(table, "velocity_m_s", rain.velocity);
  rain.stage = table.text_or("stage", "");
  rain.start_s = table.number_or("start_s", rain.start_s, kNonNegative);
  return rain;
}

ParticleTable read_particle_table(const TomlTable& table, const Folder& folder) {
  ParticleTable particles;
  table::Location location;
  try {
    location = table::parse_location(table.text("file"));
  } catch (const InputError& error) {
    table.fail("file", error.what());
  }
  location.file = absolute_from(folder, location.file);
  particles.location = table::location_text(location);
  particles.material = table.text_or("material", "");
  particles.clump = table.text_or("clump", "");
  particles.content_hash = read_content_hash(table, folder, location.file);
  return particles;
}

Particle read_particle(const TomlTable& table) {
  Particle particle;
  particle.material = table.text("material");
  particle.clump = table.text_or("clump", "");
  particle.radius_m = table.number("radius_m", kPositive);
  particle.position = vector3(table, "position_m");
  particle.velocity = vector3_or(table, "velocity_m_s", Vec3::Zero());
  particle.angular_velocity = vector3_or(table, "angular_velocity_rad_s", Vec3::Zero());
  particle.orientation_wxyz = read_orientation(table);
  return particle;
}

void write_insertion(CaseText& out, const Case& scene) {
  if (scene.fill) write_fill(out, *scene.fill);
  for (const Rain& rain : scene.rains) write_rain(out, rain);
  for (const ParticleTable& particles : scene.particle_tables) write_particle_table(out, particles);
  for (const Particle& particle : scene.particles) write_particle(out, particle);
}

}  // namespace repose::scene
