#include "output/records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/text.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem {
namespace {

std::string sizes_text(Simulation& sim) {
  const std::vector<Sphere> spheres = sim.spheres();
  const std::int64_t bodies = sim.ledger().alive;
  const double mass_kg = sim.mass_kg();
  if (spheres.empty()) return "no particles yet";
  const auto [smallest, largest] =
      std::minmax_element(spheres.begin(), spheres.end(),
                          [](const Sphere& a, const Sphere& b) { return a.radius_m < b.radius_m; });
  return fmt::format("{} bodies of {} spheres of {} to {} m, {:.9g} kg", bodies, spheres.size(),
                     shortest(2.0 * smallest->radius_m), shortest(2.0 * largest->radius_m),
                     mass_kg);
}

/// An impact's overlap goes with E^-0.4, that of a load with E^(-2/3): this is enough for both.
double stiffening(double overlap_ratio) {
  return std::pow(overlap_ratio / kSoftOverlap, 2.5);
}

std::int32_t material_of(std::int32_t sphere, Simulation& sim) {
  const std::vector<Sphere> spheres = sim.spheres();
  const auto found =
      std::lower_bound(spheres.begin(), spheres.end(), sphere,
                       [](const Sphere& candidate, std::int32_t id) { return candidate.id < id; });
  return found != spheres.end() && found->id == sphere ? found->material : -1;
}

std::string law_text(const scene::ContactModel& model) {
  using namespace scene;
  const char* rolling = model.rolling == RollingModel::a ? "type A"
                        : model.rolling_stiffness == RollingStiffness::ai
                            ? "type C, k_r of Ai"
                            : "type C, k_r = k_t R*^2";
  return fmt::format(
      "law hm1: Hertz-Mindlin, rolling {}, attraction before separation {}{}", rolling,
      model.tail == Tail::keep ? "kept" : "clipped",
      model.compatibility == Compatibility::liggghts ? ", history in the order of LIGGGHTS" : "");
}

}  // namespace

BodySums body_sums(const scene::Case& scene, Simulation& sim) {
  constexpr std::size_t kEnergy = 0, kMass = 1, kDiameter = 2, kBodies = 3, kRegions = 4;
  const std::size_t width = 1 + scene.materials.size();
  const std::vector<double> sums = sim.sum_over_bodies(
      kRegions + scene.regions.size() * width, [&](const Body& body, std::span<double> numbers) {
        numbers[kEnergy] = body.kinetic_energy_j();
        numbers[kMass] = body.mass_kg;
        numbers[kDiameter] = 2.0 * body.radius_m;
        numbers[kBodies] = 1.0;
        for (std::size_t r = 0; r < scene.regions.size(); ++r) {
          if (!scene::is_inside(scene.regions[r], body.position)) continue;
          const std::size_t first = kRegions + r * width;
          numbers[first] = body.mass_kg;
          numbers[first + 1 + static_cast<std::size_t>(body.material)] = body.mass_kg;
        }
      });
  BodySums result;
  result.kinetic_energy_j = sums[kEnergy];
  result.region_mass_kg.assign(sums.begin() + kRegions, sums.end());
  if (sums[kBodies] > 0.0)
    result.weight_scale_j =
        sums[kMass] * scene.gravity_m_s2.norm() * sums[kDiameter] / sums[kBodies];
  return result;
}

scene::Snapshot snapshot_of(const scene::Case& scene, const std::string& stage, Simulation& sim) {
  scene::Snapshot snapshot;
  snapshot.time_s = sim.time_s();
  snapshot.stage = stage;
  for (const scene::Material& material : scene.materials)
    snapshot.materials.push_back(material.name);
  for (const Sphere& s : sim.spheres()) {
    snapshot.id.push_back(s.id);
    snapshot.body.push_back(s.body);
    snapshot.material.push_back(s.material);
    snapshot.radius_m.push_back(s.radius_m);
    snapshot.mass_kg.push_back(s.mass_kg);
    snapshot.position.push_back(s.position);
    snapshot.velocity.push_back(s.velocity);
    snapshot.angular_velocity.push_back(s.angular_velocity);
  }
  return snapshot;
}

scene::WallRow wall_row_of(Simulation& sim) {
  scene::WallRow row{.time_s = sim.time_s()};
  for (const WallLoad& load : sim.take_wall_loads()) {
    row.force_n.push_back(load.force_n);
    row.torque_n_m.push_back(load.torque_n_m);
  }
  return row;
}

bool awaits_rain(const scene::Case& scene, const std::string& stage, const Simulation& sim) {
  const double outstanding_kg = sim.outstanding_rain_kg();
  if (outstanding_kg <= 0.0) return false;
  double later_kg = 0.0;
  bool is_later = false;
  for (const scene::Stage& other : scene.stages) {
    for (const scene::Rain& rain : scene.rains)
      if (is_later && rain.stage == other.name) later_kg += rain.mass_kg;
    is_later = is_later || other.name == stage;
  }
  return outstanding_kg > later_kg * (1.0 + 1e-12);
}

DeepContact deep_contact(const scene::Case& scene, const LargestOverlap& overlap, Simulation& sim) {
  const auto other = static_cast<std::size_t>(overlap.other);
  return {overlap, sim.time_s(), material_of(overlap.sphere, sim),
          overlap.is_at_wall ? scene::material_index(scene, scene.walls[other].material)
                             : material_of(overlap.other, sim)};
}

std::string soft_contact_text(const scene::Case& scene, const DeepContact& contact) {
  const LargestOverlap& overlap = contact.overlap;
  const double factor = std::max(1.1, stiffening(overlap.ratio()));
  std::vector<std::string> moduli;
  const auto add_modulus = [&](std::int32_t m) {
    if (m < 0) return;
    const scene::Material& material = scene.materials[static_cast<std::size_t>(m)];
    moduli.push_back(
        fmt::format("{:.2g} for \"{}\"", factor * material.youngs_modulus_pa, material.name));
  };
  add_modulus(contact.material);
  if (contact.partner != contact.material) add_modulus(contact.partner);
  return fmt::format(
      "contacts are soft: before {:.4g} s sphere {} overlapped {} by {:.3g} % of the smaller "
      "radius; {:.2g} times the youngs_modulus_pa{} would keep that below {:.3g} %",
      contact.time_s, overlap.sphere,
      overlap.is_at_wall
          ? "wall \"" + scene.walls[static_cast<std::size_t>(overlap.other)].name + '"'
          : fmt::format("sphere {}", overlap.other),
      100.0 * overlap.ratio(), factor, moduli.empty() ? "" : ", " + listed(moduli) + ",",
      100.0 * kSoftOverlap);
}

std::vector<std::string> head_of_log(const scene::Case& scene, Simulation& sim) {
  std::vector<std::string> lines{fmt::format(
      "repose-dem {}: {}; time step {} s = {} of the smallest Rayleigh time; {}; seed {}",
      version(), sizes_text(sim), shortest(sim.time_step_s()),
      shortest(scene.time_step_rayleigh_fraction), law_text(scene.contact), scene.seed)};
  for (const scene::PairCoefficients& p : scene.pairs)
    lines.push_back(fmt::format(
        "pair {} - {}: restitution {}, mu_s {}, mu_r {}, rolling damping {}, cohesion {} J/m^3",
        p.first, p.second, shortest(p.restitution), shortest(p.mu_s), shortest(p.mu_r),
        shortest(p.rolling_damping), shortest(p.cohesion_energy_density_j_m3)));
  const auto reports = sim.mesh_reports();
  for (std::size_t w = 0; w < reports.size(); ++w)
    if (reports[w])
      lines.push_back(fmt::format("mesh \"{}\": {}", scene.walls[w].name,
                                  scene::mesh_report_text(*reports[w])));
  return lines;
}

}  // namespace repose::dem
