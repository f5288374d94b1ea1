#include <algorithm>
#include <cmath>
#include <map>

#include "check.hpp"
#include "impact.hpp"

namespace repose::physics {
namespace {

using dem::OneMaterial;
using dem::Vec3;

/// The largest of many deviations.
class Worst {
 public:
  void see(double deviation) { value_ = std::max(value_, std::abs(deviation)); }
  double value() const { return value_; }

 private:
  double value_ = 0.0;
};

struct Hertzian {
  const char* name;
  double modulus, poisson, density, force, overlap_um, duration_us;
};

/// Tests 1 and 2: deepest overlap, largest force and duration against Hertz.
void normal_impacts(std::vector<Check>& checks) {
  const auto add = [&](const Hertzian& row, bool wall, double radius, double speed) {
    scene::Case c = dem::empty_case({.density = row.density,
                                     .youngs_modulus = row.modulus,
                                     .poissons_ratio = row.poisson,
                                     .restitution = 1.0,
                                     .mu_s = 0.35,
                                     .wall_stiffness = 1e9});
    const double gap = 1e-7 * radius;
    if (wall) {
      c.walls = {dem::floor_plane()};
      c.particles = {dem::grain(radius, {0, 0, radius + gap}, {0, 0, -speed})};
    } else {
      c.particles = {dem::grain(radius, {-radius - gap, 0, 0}, {speed, 0, 0}),
                     dem::grain(radius, {radius + gap, 0, 0}, {-speed, 0, 0})};
    }
    const double mass = dem::sphere_mass(radius, row.density);
    dem::Simulation sim(c, {.time_step_s = row.duration_us * 1e-6 / 2000});
    Vec3 before = sim.spheres()[0].velocity;
    double force = 0.0;
    std::int64_t touching = 0;
    for (int k = 0; k < 2200; ++k) {
      sim.step();
      const Vec3 now = sim.spheres()[0].velocity;
      force = std::max(force, mass * (now - before).norm() / sim.time_step_s());
      before = now;
      touching += sim.contacts() > 0 ? 1 : 0;
    }
    const std::string name = std::string(wall ? "2, " : "1, ") + row.name + ": ";
    checks.push_back({name + "largest force", force, row.force, 1e-4 * row.force, "N"});
    checks.push_back({name + "deepest overlap", sim.take_largest_overlap().ratio() * radius * 1e6,
                      row.overlap_um, 1e-4 * row.overlap_um, "µm"});
    checks.push_back({name + "duration", static_cast<double>(touching) * sim.time_step_s() * 1e6,
                      row.duration_us, 1.5e-3 * row.duration_us, "µs"});
  };
  add({"glass", 48e9, 0.20, 2800, 10696.9, 274.11, 40.34}, false, 0.010, 10.0);
  add({"limestone", 20e9, 0.25, 2500, 7108.2, 368.30, 54.20}, false, 0.010, 10.0);
  add({"aluminium alloy", 70e9, 0.30, 2699, 11369.9, 49.717, 731.7}, true, 0.1, 0.2);
  add({"magnesium alloy", 40e9, 0.35, 1800, 7232.7, 52.123, 767.1}, true, 0.1, 0.2);
}

/// Test 3: the rebound of alumina and cast iron.
void restitutions(std::vector<Check>& checks, double steps) {
  const std::map<std::string, OneMaterial> materials{
      {"aluminium oxide", {.density = 4000, .youngs_modulus = 380e9, .poissons_ratio = 0.23}},
      {"cast iron", {.density = 7000, .youngs_modulus = 100e9, .poissons_ratio = 0.25}}};
  for (const auto& [name, material] : materials)
    for (const auto& [mode, model] : {std::pair{"keep", kept()}, std::pair{"clip", clipped()}}) {
      Worst worst;
      for (double e : {0.2, 0.4, 0.6, 0.8, 0.9, 1.0}) {
        OneMaterial m = material;
        m.restitution = e;
        worst.see(impact(m, model, 0.0025, 0.0, 3.9, 0.0, steps).vz / 3.9 - e);
      }
      checks.push_back({std::string("3, ") + name + ", tail " + mode +
                            ": largest error of the restitution for e from 0.2 to 1",
                        worst.value(), 0.0, 2.0 / steps});
    }
}

/// Test 4: oblique impacts at 3.9 m/s.
void oblique(std::vector<Check>& checks, double steps) {
  const std::map<std::string, OneMaterial> materials{{"alumina",
                                                      {.density = 4000,
                                                       .youngs_modulus = 380e9,
                                                       .poissons_ratio = 0.23,
                                                       .restitution = 0.98,
                                                       .mu_s = 0.092}},
                                                     {"aluminium",
                                                      {.density = 2700,
                                                       .youngs_modulus = 70e9,
                                                       .poissons_ratio = 0.33,
                                                       .restitution = 0.98,
                                                       .mu_s = 0.092}}};
  for (const auto& [name, material] : materials) {
    Worst e_t, spin, rebound, sliding, clipped_sliding;
    for (const Row& row : read_rows("chung_ooi_4.csv")) {
      if (row.name != name) continue;
      const double degrees = row.values[0];
      const double vn = 3.9 * std::cos(degrees * kDegree), vx = 3.9 * std::sin(degrees * kDegree);
      const Rebound out = impact(material, kept(), 0.0025, vx, vn, 0.0, steps);
      e_t.see(out.vx / vx - row.values[1]);
      spin.see((out.w + row.values[2]) / 600.0);
      rebound.see(std::atan((out.vx - 0.0025 * out.w) / out.vz) / kDegree - row.values[3]);
      if (degrees < 35.0) continue;  // full sliding
      const double theory = 1.0 - 0.092 * 1.98 / std::tan(degrees * kDegree);
      sliding.see(out.vx / vx - theory);
      clipped_sliding.see(impact(material, clipped(), 0.0025, vx, vn, 0.0, steps).vx / vx - theory);
    }
    const std::string at = "4, " + name + ": largest error over 2° to 85° of ";
    checks.push_back({at + "the tangential restitution", e_t.value(), 0.0, 5e-4});
    checks.push_back({at + "the spin over 600 rad/s", spin.value(), 0.0, 1e-3});
    checks.push_back({at + "the rebound angle", rebound.value(), 0.0, 0.02, "°"});
    checks.push_back({"4, " + name + ", tail keep: e_t against 1 − μ(1+e)/tan θ for 35° and more",
                      sliding.value(), 0.0, 5e-4});
    checks.push_back({"4, " + name + ", tail clip: the same", clipped_sliding.value(), 0.0, 5e-4});
  }
}

/// Test 5: elastic oblique impacts at constant normal speed.
void elastic_oblique(std::vector<Check>& checks, double steps) {
  const std::map<std::string, OneMaterial> materials{{"steel",
                                                      {.density = 7850,
                                                       .youngs_modulus = 208e9,
                                                       .poissons_ratio = 0.3,
                                                       .restitution = 1.0,
                                                       .mu_s = 0.3}},
                                                     {"polyethylene",
                                                      {.density = 1400,
                                                       .youngs_modulus = 1e9,
                                                       .poissons_ratio = 0.3,
                                                       .restitution = 1.0,
                                                       .mu_s = 0.3}}};
  for (const auto& [name, material] : materials) {
    Worst psi, spin, theory;
    for (const Row& row : read_rows("chung_ooi_5.csv")) {
      if (row.name != name) continue;
      const double unit = 0.3 * 5.0;
      const Rebound out = impact(material, kept(), 1e-5, row.values[0] * unit, 5.0, 0.0, steps);
      const double psi2 = (out.vx - 1e-5 * out.w) / unit;
      psi.see(psi2 - row.values[1]);
      spin.see(1e-5 * out.w / unit + row.values[2]);
      if (row.values[0] >= 8.0) theory.see(psi2 - (row.values[0] - 7.0));
    }
    checks.push_back(
        {"5, " + name + ": largest error of ψ₂ over ψ₁ from 0.25 to 12", psi.value(), 0.0, 5e-3});
    checks.push_back({"5, " + name + ": largest error of R ω/(μ v_n)", spin.value(), 0.0, 5e-3});
    // The lever arm is R − d/2, and d/R of polyethylene at 5 m/s is 0.04.
    checks.push_back(
        {"5, " + name + ": ψ₂ against ψ₁ − 3.5(1+e) in full sliding", theory.value(), 0.0, 0.08});
  }
}

const std::map<std::string, OneMaterial>& spinning_materials() {
  static const std::map<std::string, OneMaterial> kMaterials{{"aluminium",
                                                              {.density = 2700,
                                                               .youngs_modulus = 70e9,
                                                               .poissons_ratio = 0.33,
                                                               .restitution = 0.5,
                                                               .mu_s = 0.4}},
                                                             {"nylon",
                                                              {.density = 1000,
                                                               .youngs_modulus = 2.5e9,
                                                               .poissons_ratio = 0.40,
                                                               .restitution = 0.5,
                                                               .mu_s = 0.4}}};
  return kMaterials;
}

/// −v_s'/v_s of the contact point of a sphere of R = 0.1 m that spins onto the plane at 0.2 m/s.
double spin_recoil(const OneMaterial& m, const scene::ContactModel& model, double x, double steps) {
  const double slip = 3.5 * 0.4 * 1.5 * 0.2 / x;
  const Rebound out = impact(m, model, 0.1, 0.0, 0.2, slip / 0.1, steps);
  return (out.vx - 0.1 * out.w) / slip;
}

/// Test 6: a spinning sphere falls onto a plane.
void spinning(std::vector<Check>& checks, double steps) {
  for (const auto& [name, material] : spinning_materials()) {
    Worst spin, speed, recoil, exact, paper;
    for (const Row& row : read_rows("chung_ooi_6.csv")) {
      if (row.name != name) continue;
      const double w = 2.0 * row.values[1];
      const Rebound out = impact(material, kept(), 0.1, 0.0, 0.2, w, steps);
      spin.see((std::abs(out.w) - row.values[5]) / w);
      speed.see((std::abs(out.vx) - std::abs(row.values[6])) / 0.12);
    }
    for (const Row& row : read_rows("chung_ooi_6_clip.csv")) {
      if (row.name != name) continue;
      const double beta = spin_recoil(material, clipped(), row.values[0], steps);
      recoil.see(beta - row.values[2]);
      if (row.values[0] < 1.0) {
        exact.see(beta - (row.values[0] - 1.0));
        paper.see(beta - row.values[1]);
      }
    }
    const std::string at = "6, " + name + ", tail ";
    checks.push_back({at + "keep: largest error of the spin over 5° to 85°, of that before",
                      spin.value(), 0.0, 5e-3});
    checks.push_back(
        {at + "keep: largest error of the speed over 0.12 m/s", speed.value(), 0.0, 5e-3});
    checks.push_back(
        {at + "clip: largest error of β over X from 0.18 to 24", recoil.value(), 0.0, 5e-3});
    checks.push_back(
        {at + "clip: β against X − 1 in full sliding, which is exact", exact.value(), 0.0, 1.5e-3});
    checks.push_back({at + "clip: distance from Chung and Ooi's digitised curve in full sliding",
                      paper.value(), 0.0, 0.02});
  }
}

struct Pair {
  dem::Sphere first, second;
};

Pair collide(const scene::Case& c, double dt) {
  dem::Simulation sim(c, {.time_step_s = dt});
  bool touched = false;
  for (int k = 0; k < 2'000'000; ++k) {
    sim.step();
    const bool touches = sim.contacts() > 0;
    if (touched && !touches) break;
    touched = touches;
  }
  return {sim.spheres()[0], sim.spheres()[1]};
}

/// Test 7: equal spheres with equal and opposite spins; test 8: a spinning sphere meets one of five
/// times its radius, a thousand times heavier and stiffer.
void pairs(std::vector<Check>& checks, double steps) {
  for (const auto& [name, modulus, poisson, density] :
       {std::tuple{"aluminium alloy", 70e9, 0.33, 2700.0},
        std::tuple{"copper", 120e9, 0.35, 8900.0}}) {
    scene::Case c = dem::empty_case({.density = density,
                                     .youngs_modulus = modulus,
                                     .poissons_ratio = poisson,
                                     .restitution = 0.5,
                                     .mu_s = 0.4});
    Worst turned, drift;
    for (double spin : {0.5, 2.0, 5.0, 10.0, 20.0}) {
      c.particles = {dem::grain(0.1, {-0.1 - 1e-8, 0, 0}, {0.2, 0, 0}, {0, spin, 0}),
                     dem::grain(0.1, {0.1 + 1e-8, 0, 0}, {-0.2, 0, 0}, {0, -spin, 0})};
      const Pair out = collide(c, 1e-6);
      turned.see(out.first.angular_velocity.y() - spin);
      drift.see(out.first.velocity.z());
    }
    checks.push_back(
        {std::string("7, ") + name + ": change of spin", turned.value(), 0.0, 0.0, "rad/s"});
    checks.push_back(
        {std::string("7, ") + name + ": tangential speed", drift.value(), 0.0, 0.0, "m/s"});
  }
  for (const auto& [name, material] : spinning_materials()) {
    scene::Case c = dem::empty_case(material);
    c.contact = clipped();
    c.materials.push_back({"heavy", 1000.0 * material.density, 1000.0 * material.youngs_modulus,
                           material.poissons_ratio});
    c.pairs.push_back(c.pairs[0]);
    c.pairs.back().second = "heavy";
    c.pairs.push_back(c.pairs[0]);
    c.pairs.back().first = c.pairs.back().second = "heavy";
    const double mass = dem::sphere_mass(0.1, material.density);
    const double e_eff = material.youngs_modulus / (1.0 - std::pow(material.poissons_ratio, 2));
    const double dt = dem::hertz_impact(e_eff, 0.1 / 1.2, mass, 0.2).duration / steps;
    Worst exact;
    for (double x : {0.18, 0.35, 0.55, 0.77}) {
      const double slip = 3.5 * 0.4 * 1.5 * 0.2 / x;
      scene::Particle big = dem::grain(0.5, {0.5, 0, 0});
      big.material = "heavy";
      c.particles = {dem::grain(0.1, {-0.1 - 1e-9, 0, 0}, {0.2, 0, 0}, {0, 0, slip / 0.1}), big};
      const dem::Sphere out = collide(c, dt).first;
      const double after = out.velocity.y() + 0.1 * out.angular_velocity.z();
      exact.see(-after / slip - (x - 1.0));
    }
    // The heavy sphere yields by 1/125000 of the momentum.
    checks.push_back(
        {"8, " + name + ", size ratio 5, tail clip: β against X − 1", exact.value(), 0.0, 2e-3});
  }
}

}  // namespace

std::vector<Check> chung_ooi(Extent extent) {
  const double steps = extent == Extent::full ? 40000.0 : 8000.0;
  std::vector<Check> checks;
  normal_impacts(checks);
  restitutions(checks, steps);
  oblique(checks, steps);
  elastic_oblique(checks, steps);
  spinning(checks, steps);
  pairs(checks, steps);
  return checks;
}

}  // namespace repose::physics
