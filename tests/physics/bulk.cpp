// Many spheres: discharge through outlets, and heaps.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "check.hpp"
#include "repose/dem/run_case.hpp"
#include "repose/dem/simulation.hpp"
#include "repose/dem_adapter/drawdown.hpp"

namespace repose::physics {
namespace {

using scene::Vec3;

enum class Outlet { slot, circle };

constexpr double kDiameter = 0.004;  // mean; uniform in mass from 0.9 to 1.1 of it
constexpr double kDensity = 2500.0;
constexpr double kSide = 25.0 * kDiameter;  // period in x, and in y above a circle

scene::Wall wall(const std::string& name, const scene::Shape& shape) {
  return {name, "steel", shape};
}

/// A bed over a flat floor with an outlet of width or diameter D, periodic to the sides, so that no
/// wall carries it.
scene::Case silo(Outlet outlet, double opening, double height) {
  const double thickness = outlet == Outlet::slot ? 4.0 * kDiameter : kSide;
  scene::Case c;
  c.time_step_rayleigh_fraction = 0.2;
  c.lower_m = {-0.5 * kSide, 0.0, -3.0};
  c.upper_m = {0.5 * kSide, thickness, 4.0 * height};
  c.periodic = {true, true, false};
  c.materials = {{"glass", kDensity, 1e7, 0.25}, {"steel", 7850.0, 1e9, 0.3}};
  scene::PairCoefficients pair;
  pair.restitution = 0.7;
  pair.mu_s = 0.5;
  pair.first = pair.second = "glass";
  c.pairs.push_back(pair);
  pair.second = "steel";
  c.pairs.push_back(pair);
  if (outlet == Outlet::slot) {
    const Vec3 across(0.0, thickness, 0.0), side(0.5 * (kSide - opening), 0.0, 0.0);
    c.walls = {wall("left", scene::Rectangle{{-0.5 * kSide, 0, 0}, side, across}),
               wall("right", scene::Rectangle{{0.5 * opening, 0, 0}, side, across}),
               wall("gate", scene::Rectangle{{-0.5 * opening, 0, 0}, {opening, 0, 0}, across})};
  } else {
    const Vec3 centre(0.0, 0.5 * kSide, 0.0);
    c.walls = {wall("floor", scene::Disc{centre, Vec3::UnitZ(), kSide, 0.5 * opening}),
               wall("gate", scene::Disc{centre, Vec3::UnitZ(), 0.5 * opening, 0.0})};
  }
  scene::Fill fill;
  fill.lower = {c.lower_m.x(), 0.0, 0.0};
  fill.upper = {c.upper_m.x(), thickness, 4.0 * height};
  scene::Grains grains;
  grains.material = "glass";
  grains.sizes = std::vector<scene::SizeClass>{{0.9 * kDiameter, 1.1 * kDiameter, 1.0}};
  fill.layers = {{0.6 * kDensity * kSide * thickness * height, {grains}}};
  c.fill = fill;
  return c;
}

struct Discharge {
  double opening = 0.0;
  double flow_kg_s = 0.0;
  double bulk_density_kg_m3 = 0.0;
};

Discharge discharge(Outlet outlet, double opening, double height, double start_s, double flow_s) {
  const scene::Case c = silo(outlet, opening, height);
  dem::Simulation sim(c);
  while (sim.time_s() < 0.3) sim.step(100);
  Discharge out{opening, 0.0, 0.0};
  const double floor_area = kSide * c.upper_m.y();
  for (const dem::Sphere& s : sim.spheres())
    if (s.position.z() > 0.2 * height && s.position.z() < 0.6 * height)
      out.bulk_density_kg_m3 += s.mass_kg / (0.4 * height * floor_area);
  sim.open("gate");
  const double opened = sim.time_s();
  while (sim.time_s() < opened + start_s) sim.step(50);
  // Least squares of the mass below the floor over time.
  double n = 0, t1 = 0, t2 = 0, m1 = 0, tm = 0;
  while (sim.time_s() < opened + start_s + flow_s) {
    sim.step(50);
    double mass = 0.0;
    for (const dem::Sphere& s : sim.spheres())
      if (s.position.z() < 0.0) mass += s.mass_kg;
    const double t = sim.time_s() - opened;
    n += 1, t1 += t, t2 += t * t, m1 += mass, tm += t * mass;
  }
  out.flow_kg_s = (n * tm - t1 * m1) / (n * t2 - t1 * t1);
  return out;
}

/// Beverloo's law W = C rho_b sqrt(g) L^j (D - k d)^p, from the line W^(1/p) over D.
struct Beverloo {
  double constant = 0.0, k = 0.0;
  double exponent = 0.0;  ///< of W over D - 1.4 d
};

Beverloo fit(const std::vector<Discharge>& all, double power, double length) {
  double n = 0, x1 = 0, x2 = 0, y1 = 0, xy = 0, u1 = 0, u2 = 0, w1 = 0, uw = 0, density = 0;
  for (const Discharge& d : all) {
    const double y = std::pow(d.flow_kg_s, 1.0 / power);
    n += 1, x1 += d.opening, x2 += d.opening * d.opening, y1 += y, xy += d.opening * y;
    const double u = std::log(d.opening - 1.4 * kDiameter), w = std::log(d.flow_kg_s);
    u1 += u, u2 += u * u, w1 += w, uw += u * w;
    density += d.bulk_density_kg_m3;
  }
  const double slope = (n * xy - x1 * y1) / (n * x2 - x1 * x1);
  const double intercept = (y1 - slope * x1) / n;
  return {std::pow(slope, power) / (density / n * std::sqrt(9.81) * length),
          -intercept / (slope * kDiameter), (n * uw - u1 * w1) / (n * u2 - u1 * u1)};
}

}  // namespace

std::vector<Check> beverloo(Extent extent) {
  const bool full = extent == Extent::full;
  std::vector<Check> checks;
  std::vector<Discharge> slots;
  for (double opening : full ? std::vector{5.0, 6.0, 7.0, 8.0, 9.0} : std::vector{5.0, 6.5, 8.0})
    slots.push_back(
        discharge(Outlet::slot, opening * kDiameter, full ? 0.15 : 0.10, 0.06, full ? 0.20 : 0.12));
  const Beverloo slot = fit(slots, 1.5, 4.0 * kDiameter);
  checks.push_back(
      {"slot: exponent of the flow over D − 1.4 d", slot.exponent, 1.5, full ? 0.1 : 0.2});
  checks.push_back({"slot: k", slot.k, 1.4, 0.6});
  checks.push_back({"slot: C of W = C ρ_b √g L (D − k d)^1.5", slot.constant, 1.03, 0.2, "",
                    full ? Demand::near : Demand::report});
  if (!full) return checks;
  std::vector<Discharge> circles;
  for (double opening : {6.0, 7.0, 8.0, 9.0, 10.0})
    circles.push_back(discharge(Outlet::circle, opening * kDiameter, 0.09, 0.06, 0.15));
  const Beverloo circle = fit(circles, 2.5, 1.0);
  checks.push_back({"flat circular orifice, five outlets: exponent of the flow over D − 1.4 d",
                    circle.exponent, 2.5, 0.1});
  checks.push_back({"flat circular orifice: k", circle.k, 1.4, 0.1});
  checks.push_back(
      {"flat circular orifice: C of W = C ρ_b √g (D − k d)^2.5", circle.constant, 0.60, 0.05});
  return checks;
}

namespace {

/// Angle of repose of the quick draw-down rig, mean over seeds.
double heap_angle(double mu_s, double mu_r, int seeds) {
  dem_adapter::Drawdown rig = dem_adapter::Drawdown::preset("quick");
  for (const char* pair : {"pp", "ss", "ps", "pg", "sg"}) {
    rig.coefficients[std::string("mu_s_") + pair] = mu_s;
    rig.coefficients[std::string("mu_r_") + pair] = mu_r;
  }
  double sum = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() /
        ("repose_heap_" + std::to_string(::getpid()) + "_" + std::to_string(seed));
    dem::run_case(rig.make_case({}, static_cast<std::uint64_t>(seed)), folder);
    sum += rig.measure(scene::read_run(folder)).kpis.at("angle_of_repose_deg");
    std::filesystem::remove_all(folder);
  }
  return sum / seeds;
}

}  // namespace

std::vector<Check> angle_of_repose(Extent extent) {
  const bool full = extent == Extent::full;
  const int seeds = full ? 4 : 1;
  const std::vector<double> sliding = full ? std::vector{0.1, 0.3, 0.6} : std::vector{0.1, 0.6};
  const std::vector<double> rolling = full ? std::vector{0.01, 0.1, 0.3} : std::vector{0.01, 0.3};
  std::vector<Check> checks;
  // A mean over n seeds scatters by 1.3/sqrt(n) degrees; two such means by 1.8/sqrt(n).
  const double least = 2.0 * 1.8 / std::sqrt(seeds);
  double before = 0.0;
  for (std::size_t i = 0; i < sliding.size(); ++i) {
    const double angle = heap_angle(sliding[i], 0.2, seeds);
    checks.push_back({"μ_r = 0.2, μ_s = " + std::to_string(sliding[i]).substr(0, 4) +
                          ": angle of repose, above the one before",
                      angle, i == 0 ? 0.0 : before + least, 0.0, "°",
                      i == 0 ? Demand::report : Demand::at_least});
    before = angle;
  }
  for (std::size_t i = 0; i < rolling.size(); ++i) {
    const double angle = heap_angle(0.5, rolling[i], seeds);
    checks.push_back({"μ_s = 0.5, μ_r = " + std::to_string(rolling[i]).substr(0, 4) +
                          ": angle of repose, above the one before",
                      angle, i == 0 ? 0.0 : before + least, 0.0, "°",
                      i == 0 ? Demand::report : Demand::at_least});
    before = angle;
  }
  return checks;
}

}  // namespace repose::physics
