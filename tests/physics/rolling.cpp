// Sliding and rolling of one sphere on a plane: closed forms of friction and of rolling resistance.
#include <algorithm>
#include <cmath>
#include <utility>

#include "check.hpp"
#include "impact.hpp"

namespace repose::physics {
namespace {

constexpr double kGravity = 9.81;
constexpr double kRadius = 0.005;

/// R = 5 mm, 2500 kg/m3, E = 50 MPa, nu = 0.3, mu = 0.5, mu_r = 0.1, eta = 0.3.
dem::OneMaterial material(double mu_r, double eta = 0.3, double e = 0.5) {
  return {.density = 2500,
          .youngs_modulus = 50e6,
          .poissons_ratio = 0.3,
          .restitution = e,
          .mu_s = 0.5,
          .mu_r = mu_r,
          .rolling_damping = eta};
}

/// A sphere at rest in its static overlap on the plane, tilted by `slope`, then set rolling.
struct OnPlane {
  dem::OneMaterial m;
  scene::ContactModel model{};
  double slope = 0.0;
  double speed = 0.0;
  double spin = 0.0;

  double e_eff() const {
    return m.youngs_modulus / (2.0 * (1.0 - m.poissons_ratio * m.poissons_ratio));
  }
  double mass() const { return dem::sphere_mass(kRadius, m.density); }
  double overlap() const {
    return dem::hertz_overlap(e_eff(), kRadius, mass() * kGravity * std::cos(slope));
  }
  double contact_radius() const { return std::sqrt(kRadius * overlap()); }
  double tangential_stiffness() const {
    const double shear = m.youngs_modulus / (2.0 * (1.0 + m.poissons_ratio));
    return 8.0 * shear / (2.0 * (2.0 - m.poissons_ratio)) * contact_radius();
  }
  double rolling_stiffness() const {
    return model.rolling_stiffness == scene::RollingStiffness::kt
               ? tangential_stiffness() * kRadius * kRadius
               : 3.0 * e_eff() * contact_radius() * std::pow(m.mu_r * kRadius, 2);
  }
  double rolling_inertia() const { return 1.4 * mass() * kRadius * kRadius; }
  dem::Simulation start(double fraction = 0.1) const {
    scene::Case c = dem::empty_case(m);
    c.contact = model;
    c.time_step_rayleigh_fraction = fraction;
    c.gravity_m_s2 = {kGravity * std::sin(slope), 0.0, -kGravity * std::cos(slope)};
    c.walls = {dem::floor_plane()};
    c.particles = {dem::grain(kRadius, {0, 0, kRadius - overlap()}, {speed, 0, 0}, {0, spin, 0})};
    return dem::Simulation(c);
  }
};

void run_until(dem::Simulation& sim, double time) {
  while (sim.time_s() < time) sim.step();
}

void slip_to_roll(std::vector<Check>& checks) {
  const OnPlane plane{.m = material(0.0), .speed = 0.2};
  dem::Simulation sim = plane.start();
  run_until(sim, 0.2);
  const dem::Sphere s = sim.spheres()[0];
  const double arm = plane.overlap() / kRadius;  // R - d/2 instead of R
  checks.push_back(
      {"slip turns into rolling at 5/7 of the speed", s.velocity.x() / 0.2, 5.0 / 7.0, arm});
  checks.push_back({"then R ω = v", kRadius * s.angular_velocity.y() / s.velocity.x(), 1.0, arm});
}

/// Time and path to rest, from v_0 = 0.1 m/s in pure rolling.
void rolling_stop(std::vector<Check>& checks, const char* name, const scene::ContactModel& model) {
  const double v0 = 0.1, deceleration = 5.0 / 7.0 * 0.1 * kGravity;
  const OnPlane plane{.m = material(0.1), .model = model, .speed = v0, .spin = v0 / kRadius};
  dem::Simulation sim = plane.start();
  while (sim.spheres()[0].velocity.x() > 0.0 && sim.time_s() < 1.0) sim.step();
  // Winding the spring up takes an angle M_max/k_r, during which the dashpot takes C_r/I_r of that
  // angle from the angular velocity; type A has no spring.
  const bool spring = model.rolling == scene::RollingModel::c;
  const double winding =
      spring ? 0.1 * kRadius * plane.mass() * kGravity / plane.rolling_stiffness() : 0.0;
  const double speed =
      v0 - 0.6 * std::sqrt(plane.rolling_stiffness() / plane.rolling_inertia()) * winding * kRadius;
  // Where the rolling spring is as stiff as the tangential one, that does not carry while it winds
  // up: the dashpot then brakes 0.4 m R^2 instead of 1.4 m R^2, up to 3.5 times as much.
  const bool stiff = spring && model.rolling_stiffness == scene::RollingStiffness::kt;
  const double slack = 2.0 * winding * kRadius / v0 + 2e-3 * v0 / deceleration +
                       (stiff ? 2.5 * (v0 - speed) / deceleration : 0.0);
  checks.push_back({std::string(name) + ": time to stop from 0.1 m/s", sim.time_s(),
                    speed / deceleration, slack, "s"});
  checks.push_back({std::string(name) + ": path", sim.spheres()[0].position.x() * 1e3,
                    1e3 * speed * speed / (2.0 * deceleration), 1e3 * slack * v0, "mm"});
  run_until(sim, 2.0);
  const double at = sim.spheres()[0].position.x();
  run_until(sim, 3.0);
  checks.push_back({std::string(name) + ": speed at rest, after 3 s",
                    sim.spheres()[0].velocity.norm(), 0.0, 1e-12, "m/s"});
  checks.push_back({std::string(name) + ": creep between 2 and 3 s",
                    std::abs(sim.spheres()[0].position.x() - at), 0.0, 1e-12, "m"});
}

/// Lowest frequency of rolling on k_r and k_t: m x" = -k_t (x - R q), I q" = k_t R (x - R q) - k_r
/// q.
double rolling_frequency(const OnPlane& plane) {
  const double m = plane.mass(), inertia = 0.4 * m * kRadius * kRadius;
  const double k_t = plane.tangential_stiffness();
  const double a = k_t / m, b = (k_t * kRadius * kRadius + plane.rolling_stiffness()) / inertia;
  const double c = k_t * kRadius / m * k_t * kRadius / inertia;
  return std::sqrt(0.5 * (a + b - std::sqrt((a - b) * (a - b) + 4.0 * c)));
}

/// Half period and ratio of successive peaks of the velocity of a sphere that rocks.
struct Rocking {
  double half_period = 0.0, peak_ratio = 0.0;
};

Rocking rock(const OnPlane& plane) {
  dem::Simulation sim = plane.start(0.05);
  std::vector<double> zeros, peaks;
  double before = plane.speed, peak = 0.0;
  while (zeros.size() < 4 && sim.time_s() < 1.0) {
    sim.step();
    const double now = sim.spheres()[0].velocity.x();
    peak = std::max(peak, std::abs(now));
    if (before * now <= 0.0 && now != before) {
      zeros.push_back(sim.time_s() - sim.time_step_s() * now / (now - before));
      peaks.push_back(std::exchange(peak, 0.0));
    }
    before = now;
  }
  if (zeros.size() < 4) return {};
  return {(zeros[3] - zeros[0]) / 3.0, std::sqrt(peaks[3] / peaks[1])};
}

void rocking(std::vector<Check>& checks, const char* name, const scene::ContactModel& model) {
  const auto plane = [&](double eta) {
    return OnPlane{
        .m = material(0.1, eta, 1.0), .model = model, .speed = 1e-5, .spin = 1e-5 / kRadius};
  };
  const double exact = std::numbers::pi / rolling_frequency(plane(0.0));
  checks.push_back({std::string(name) + ": half period of rocking without damping",
                    1e3 * rock(plane(0.0)).half_period, 1e3 * exact, 0.01 * 1e3 * exact, "ms"});
  if (model.rolling_stiffness == scene::RollingStiffness::kt) return;  // k_t acts in series there
  const Rocking damped = rock(plane(0.3));
  checks.push_back({std::string(name) + ": half period with η = 0.3", 1e3 * damped.half_period,
                    1e3 * exact / std::sqrt(0.91), 0.01 * 1e3 * exact, "ms"});
  checks.push_back({std::string(name) + ": ratio of successive peaks with η = 0.3",
                    damped.peak_ratio, std::exp(-std::numbers::pi * 0.3 / std::sqrt(0.91)), 0.02});
}

void slopes(std::vector<Check>& checks, const char* name, const scene::ContactModel& model) {
  const double below = std::atan(0.08), above = std::atan(0.12);
  dem::Simulation held = OnPlane{.m = material(0.1), .model = model, .slope = below}.start();
  run_until(held, 1.0);
  checks.push_back({std::string(name) + ": speed on a slope of tan θ = 0.08 < μ_r",
                    held.spheres()[0].velocity.norm(), 0.0, 1e-9, "m/s"});
  dem::Simulation free = OnPlane{.m = material(0.1), .model = model, .slope = above}.start();
  run_until(free, 0.5);
  const double start = free.spheres()[0].velocity.x(), from = free.time_s();
  run_until(free, 1.0);
  checks.push_back({std::string(name) + ": acceleration on tan θ = 0.12",
                    (free.spheres()[0].velocity.x() - start) / (free.time_s() - from),
                    5.0 / 7.0 * kGravity * (std::sin(above) - 0.1 * std::cos(above)), 1e-3,
                    "m/s²"});
}

}  // namespace

std::vector<Check> sliding_and_rolling(Extent) {
  std::vector<Check> checks;
  slip_to_roll(checks);
  scene::ContactModel kt;
  kt.rolling_stiffness = scene::RollingStiffness::kt;
  scene::ContactModel liggghts;
  liggghts.compatibility = scene::Compatibility::liggghts;
  scene::ContactModel type_a;
  type_a.rolling = scene::RollingModel::a;
  for (const auto& [name, model] :
       {std::pair{"type C, k_r of Ai", kept()}, std::pair{"type C, k_r = k_t R²", kt},
        std::pair{"type C, compat liggghts", liggghts}}) {
    rolling_stop(checks, name, model);
    rocking(checks, name, model);
    slopes(checks, name, model);
  }
  rolling_stop(checks, "type A", type_a);
  return checks;
}

}  // namespace repose::physics
