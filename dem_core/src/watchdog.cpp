// What ends a run that has become unphysical: overlaps and speeds that nothing explains.
#include <algorithm>
#include <cmath>

#include "contact/impact.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

// Of the smaller radius. Soft spheres that fall far may come up to 36 % without anything being
// wrong; beyond 50 % a sphere may pass through the other.
constexpr double kLargestOverlap = 0.3;
constexpr double kLargestOverlapOfAnImpact = 0.5;
// A small sphere between large ones can be shot out at several times their speed, not at this.
constexpr double kSpeedJump = 10.0;
constexpr double kHarmlessOverlap = 0.05;  // of the radius, in an impact at a speed that jumped

}  // namespace

void Simulation::State::watch_overlap(const DeepestOverlap& now) {
  if (now.ratio() > largest_overlap.ratio()) {
    const auto other = static_cast<std::size_t>(now.other);
    largest_overlap = {now.overlap, now.radius, spheres.id[static_cast<std::size_t>(now.sphere)],
                       now.is_wall ? now.other : spheres.id[other], now.is_wall};
  }
  if (now.ratio() <= kLargestOverlap) return;
  const double allowed = allowed_overlap_ratio(now);
  if (now.ratio() <= allowed) return;
  if (steps == 0)
    throw InputError("at the start " + overlap_text(now, allowed) +
                     "; move them apart, or the particle is larger than its container");
  throw SimulationError(overlap_text(now, allowed) + ", " +
                        speed_and_time(static_cast<std::size_t>(now.sphere)) +
                        "; raise youngs_modulus_pa or lower the time step");
}

/// Twice what an elastic impact at the largest speed so far would give, but no less than 30 % and
/// no more than 50 % of the smaller radius.
double Simulation::State::allowed_overlap_ratio(const DeepestOverlap& now) const {
  const auto i = static_cast<std::size_t>(now.sphere);
  const auto other = static_cast<std::size_t>(now.other);
  const Motion& a = spheres.motion[i];
  const std::int32_t partner = now.is_wall ? walls.at(other).material : spheres.material[other];
  const ContactBodies bodies =
      now.is_wall ? sphere_wall(a.radius, 1.0 / a.inv_mass)
                  : sphere_sphere(a.radius, 1.0 / a.inv_mass, spheres.motion[other].radius,
                                  1.0 / spheres.motion[other].inv_mass);
  const double e_eff = laws.at(spheres.material[i], partner).e_eff;
  const double of_impact = impact_overlap(e_eff, bodies, largest_speed) / now.radius;
  return std::clamp(2.0 * of_impact, kLargestOverlap, kLargestOverlapOfAnImpact);
}

/// Index of the fastest sphere; 0 if there is none.
std::size_t Simulation::State::fastest_sphere() const {
  std::size_t fastest = 0;
  for (std::size_t i = 1; i < spheres.size(); ++i)
    if (spheres.motion[i].v.squaredNorm() > spheres.motion[fastest].v.squaredNorm()) fastest = i;
  return fastest;
}

/// No sphere may be ten times as fast as any before, as a fall through the whole domain, as walls
/// and as rain, unless it is so slow all the same that its impact would be harmless.
void Simulation::State::watch_speed() {
  const std::size_t i = fastest_sphere();
  double fastest[1] = {spheres.size() == 0 ? 0.0 : spheres.motion[i].v.norm()};
  domain.communicator().maximize(fastest);
  if (steps > 0 && spheres.size() > 0) attempt([&] { check_jump(i); });
  largest_speed = std::max(largest_speed, fastest[0]);
}

void Simulation::State::check_jump(std::size_t i) const {
  const Motion& sphere = spheres.motion[i];
  const double speed = sphere.v.norm();
  const double fall_2 = 2.0 * scene.gravity_m_s2.norm() * (box.upper - box.lower).norm();
  double expected = std::max(largest_speed, std::sqrt(fall_2));
  if (dt > 0.0) expected = std::max(expected, walls.largest_step().distance / dt);
  for (const scene::Rain& rain : scene.rains) expected = std::max(expected, rain.velocity.norm());
  if (speed > kSpeedJump * expected) {
    const double mass = 1.0 / sphere.inv_mass;
    const ContactBodies equal = sphere_sphere(sphere.radius, mass, sphere.radius, mass);
    const double e_eff = laws.at(spheres.material[i], spheres.material[i]).e_eff;
    if (speed > impact_speed(e_eff, equal, kHarmlessOverlap * sphere.radius))
      throw SimulationError(
          name_of(i) + " at " + place_text(sphere.x) + " has jumped to " + speed_and_time(i) +
          ", while nothing before it, no wall, no rain and no fall through the domain was faster "
          "than " +
          shortest(std::round(expected * 1e4) / 1e4) +
          " m/s; lower the time step (time_step_rayleigh_fraction), or look for particles that "
          "began in each other");
  }
}

std::string Simulation::State::overlap_text(const DeepestOverlap& now, double allowed) const {
  const auto percent = [](double ratio) { return shortest(std::round(100.0 * ratio)) + " %"; };
  const auto i = static_cast<std::size_t>(now.sphere);
  const auto other = static_cast<std::size_t>(now.other);
  const std::string partner =
      now.is_wall ? "wall \"" + scene.walls[other].name + "\"" : name_of(other);
  return name_of(i) + " at " + place_text(spheres.motion[i].x) + " overlaps " + partner + " by " +
         percent(now.ratio()) + " of the smaller radius; at most " + percent(allowed) +
         " is allowed";
}

}  // namespace repose::dem
