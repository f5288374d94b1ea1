// Impacts beyond the published tests: all angles, frictions, restitutions and speeds.
#include "impact.hpp"

#include <algorithm>
#include <cmath>

#include "check.hpp"

namespace repose::physics {

std::vector<Check> oblique_impacts(Extent extent) {
  const bool full = extent == Extent::full;
  const double steps = full ? 10000.0 : 2000.0;
  std::vector<double> angles;
  for (double a = 0.0; a <= 89.0; a += full ? 1.0 : 4.45) angles.push_back(a);
  scene::ContactModel liggghts;
  liggghts.compatibility = scene::Compatibility::liggghts;
  std::vector<Check> checks;
  for (const auto& [mode, model] :
       {std::pair{"tail keep", kept()}, std::pair{"tail clip", clipped()},
        std::pair{"tail keep, compat liggghts", liggghts}})
    for (double e : {1.0, 0.9, 0.5}) {
      double highest = 0.0, at_angle = 0.0, at_mu = 0.0;
      for (double mu : {0.05, 0.1, 0.2, 0.4, 0.7, 1.0})
        for (double angle : angles) {
          const dem::OneMaterial m{.youngs_modulus = 1e9, .restitution = e, .mu_s = mu};
          const double vn = std::cos(angle * kDegree), vx = std::sin(angle * kDegree);
          const Rebound out = impact(m, model, 0.005, vx, vn, 0.0, steps);
          const double energy =
              out.vx * out.vx + out.vz * out.vz + 0.4 * std::pow(0.005 * out.w, 2);
          if (energy > highest) highest = energy, at_angle = angle, at_mu = mu;
        }
      checks.push_back({std::string(mode) + ", e = " + std::to_string(e).substr(0, 3) +
                            ": largest energy after, of that before, over 0° to 89° and μ from "
                            "0.05 to 1 (at " +
                            std::to_string(static_cast<int>(at_angle)) +
                            "°, μ = " + std::to_string(at_mu).substr(0, 4) + ")",
                        highest, 1.0, 4.0 / steps, "", Demand::at_most});
    }
  return checks;
}

std::vector<Check> restitution(Extent extent) {
  const double steps = extent == Extent::full ? 8000.0 : 2000.0;
  std::vector<Check> checks;
  for (const auto& [mode, model] : {std::pair{"keep", kept()}, std::pair{"clip", clipped()}})
    for (double speed : {0.01, 0.1, 1.0, 5.0}) {
      double worst = 0.0;
      for (double e = 0.05; e < 1.0; e += 0.05) {
        const dem::OneMaterial m{.youngs_modulus = 1e9, .restitution = e};
        worst = std::max(worst,
                         std::abs(impact(m, model, 0.005, 0.0, speed, 0.0, steps).vz / speed - e));
      }
      checks.push_back({std::string("tail ") + mode + ", " + std::to_string(speed).substr(0, 4) +
                            " m/s: largest error over e from 0.05 to 0.95",
                        worst, 0.0, 4.0 / steps});
    }
  return checks;
}

namespace {

/// log2 of the ratio of errors when the step is halved, averaged over three halvings; errors are
/// root mean squares over where in a step the contact begins.
double observed_order(const dem::OneMaterial& m, double vx, double exact_vx, double exact_vz) {
  const auto error = [&](double steps) {
    double sum = 0.0;
    for (double gap : {0.07, 0.19, 0.31, 0.43, 0.57, 0.69, 0.81, 0.93}) {
      const Rebound out = impact(m, kept(), 0.005, vx, 1.0, 0.0, steps, gap);
      sum += std::pow(out.vx - exact_vx, 2) + std::pow(out.vz - exact_vz, 2);
    }
    return std::sqrt(sum);
  };
  return std::log2(error(200.0) / error(1600.0)) / 3.0;
}

}  // namespace

std::vector<Check> time_step_order(Extent) {
  const dem::OneMaterial elastic{.youngs_modulus = 1e9, .restitution = 1.0};
  const dem::OneMaterial damped{.youngs_modulus = 1e9, .restitution = 0.5};
  const dem::OneMaterial rough{.youngs_modulus = 1e9, .restitution = 0.5, .mu_s = 0.3};
  // In a stuck impact without a closed form the reference is the same law with fine steps.
  const Rebound fine = impact(rough, kept(), 0.005, 0.4, 1.0, 0.0, 400000.0);
  return {{"elastic normal impact", observed_order(elastic, 0.0, 0.0, 1.0), 1.5, 0.0, "",
           Demand::at_least},
          {"damped normal impact", observed_order(damped, 0.0, 0.0, 0.5), 1.0, 0.15, "",
           Demand::at_least},
          {"damped oblique impact with friction", observed_order(rough, 0.4, fine.vx, fine.vz), 1.0,
           0.15, "", Demand::at_least}};
}

}  // namespace repose::physics
