#include "impact.hpp"

#include <fstream>
#include <sstream>
#include <utility>

#include "repose/base/error.hpp"

namespace repose::physics {

Rebound impact(dem::OneMaterial material, const scene::ContactModel& model, double radius,
               double vx, double vn, double w, double steps, double gap_steps) {
  material.wall_stiffness = 1e9;
  scene::Case c = dem::empty_case(material);
  c.contact = model;
  c.walls = {dem::floor_plane()};
  const double e_eff =
      material.youngs_modulus / (1.0 - material.poissons_ratio * material.poissons_ratio);
  const double mass = dem::sphere_mass(radius, material.density);
  const double duration = dem::hertz_impact(e_eff, radius, mass, vn).duration;
  const double gap = 1e-9 * radius + gap_steps * vn * duration / steps;
  c.particles = {dem::grain(radius, {0, 0, radius + gap}, {vx, 0, -vn}, {0, w, 0})};
  dem::Simulation sim(c, {.time_step_s = duration / steps});
  sim.step(static_cast<std::int64_t>(1.5 * steps));
  while (sim.contacts() > 0) sim.step(1000);
  const dem::Sphere s = sim.spheres()[0];
  return {s.velocity.x(), s.velocity.z(), s.angular_velocity.y()};
}

std::vector<Row> read_rows(const std::string& file) {
  const std::string path = std::string(REPOSE_TEST_DATA) + "/dem/" + file;
  std::ifstream in(path);
  if (!in) throw StorageError("cannot read " + path);
  std::vector<Row> rows;
  bool header = true;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (std::exchange(header, false)) continue;
    std::istringstream cells(line);
    Row row;
    std::getline(cells, row.name, ',');
    for (std::string cell; std::getline(cells, cell, ',');) row.values.push_back(std::stod(cell));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace repose::physics
