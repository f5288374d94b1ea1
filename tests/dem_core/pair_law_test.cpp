#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "repose/dem/pair_law.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// Restitution of d'' = -d^1.5 - sqrt5 beta d^0.25 d' from d = 0, d' = 1, until the force would
/// attract; fourth-order Runge-Kutta, which d^0.25 at the start lowers to order 1.25 or better.
double clipped_restitution(double beta) {
  const auto acceleration = [&](double d, double v) {
    const double overlap = std::max(d, 0.0);
    return -std::pow(overlap, 1.5) - std::sqrt(5.0) * beta * std::pow(overlap, 0.25) * v;
  };
  double d = 0.0, v = 1.0;
  const double h = 2e-5;
  while (v > 0.0 || acceleration(d, v) < 0.0) {
    const double d2 = v, v2 = acceleration(d, v);
    const double d3 = v + 0.5 * h * v2, v3 = acceleration(d + 0.5 * h * d2, d3);
    const double d4 = v + 0.5 * h * v3, v4 = acceleration(d + 0.5 * h * d3, d4);
    const double d5 = v + h * v4, v5 = acceleration(d + h * d4, d5);
    d += h / 6.0 * (d2 + 2.0 * d3 + 2.0 * d4 + d5);
    v += h / 6.0 * (v2 + 2.0 * v3 + 2.0 * v4 + v5);
    if (d <= 0.0) break;
  }
  return -v;
}

TEST(ClippedDamping, EqualsATableOfRootsFoundByIntegration) {
  std::ifstream in(REPOSE_TEST_DATA "/dem/clipped_damping.csv");
  std::string line;
  int rows = 0;
  while (std::getline(in, line)) {
    double e = 0.0, beta = 0.0;
    char comma = 0;
    if (!(std::istringstream(line) >> e >> comma >> beta)) continue;
    // The table's integration was of first order in its step: 2e-4 at worst, at e = 0.05.
    EXPECT_NEAR(clipped_damping_ratio(e), beta, 2e-4 * beta + 1e-6) << e;
    ++rows;
  }
  EXPECT_EQ(rows, 20);
}

TEST(ClippedDamping, GivesItsRestitutionInADirectIntegration) {
  for (double e : {0.05, 0.1, 0.13, std::exp(-2.0), 0.14, 0.3, 0.5, 0.8, 0.99})
    EXPECT_NEAR(clipped_restitution(clipped_damping_ratio(e)), e, 1e-5) << e;
}

TEST(ClippedDamping, InvertsItsClosedForm) {
  const auto restitution = [](double beta) {
    if (beta < 1.0) return std::exp(-2.0 * std::acos(beta) * beta / std::sqrt(1.0 - beta * beta));
    return std::exp(-2.0 * std::acosh(beta) * beta / std::sqrt(beta * beta - 1.0));
  };
  for (double e = 0.01; e < 0.999; e += 0.0137)
    EXPECT_NEAR(restitution(clipped_damping_ratio(e)), e, 1e-10 * e) << e;
  EXPECT_EQ(clipped_damping_ratio(1.0), 0.0);
  // Where both forms meet: beta = 1 at e = exp(-2), with a continuous slope d ln e/d beta = -4/3.
  EXPECT_NEAR(clipped_damping_ratio(std::exp(-2.0)), 1.0, 1e-12);
  EXPECT_NEAR(clipped_damping_ratio(std::exp(-2.0 - 4e-6)), 1.0 + 3e-6, 1e-11);
  EXPECT_NEAR(clipped_damping_ratio(std::exp(-2.0 + 4e-6)), 1.0 - 3e-6, 1e-11);
  // Small losses: (pi/2) beta = -ln(e)/2, as with the attraction.
  EXPECT_NEAR(clipped_damping_ratio(1.0 - 1e-9) / (1e-9 / std::numbers::pi), 1.0, 1e-6);
}

TEST(PairLaw, OfSteelOnNylonEqualsItsFormulas) {
  const scene::Material steel{"steel", 7850, 208e9, 0.3};
  const scene::Material nylon{"nylon", 1000, 2.5e9, 0.4};
  scene::PairCoefficients pair;
  pair.restitution = 0.6;
  pair.mu_r = 0.2;
  pair.rolling_damping = 0.3;
  const PairLaw law = make_pair_law(steel, nylon, pair);
  const double e_eff = 1.0 / (0.91 / 208e9 + 0.84 / 2.5e9);
  const double g_eff = 0.5 / (1.7 * 1.3 / 208e9 + 1.6 * 1.4 / 2.5e9);
  // 1/G* = 2 (2 - nu)(1 + nu)/E, summed.
  EXPECT_NEAR(law.e_eff, e_eff, 1e-14 * e_eff);
  EXPECT_NEAR(law.g_eff, g_eff, 1e-14 * g_eff);
  EXPECT_NEAR(law.beta, 0.160493, 5e-7);
  EXPECT_NEAR(law.rolling_k, 2.25 * 4.0 / 3.0 * e_eff * 0.04, 1e-13 * e_eff);
  scene::ContactModel kt;
  kt.rolling_stiffness = scene::RollingStiffness::kt;
  const PairLaw stiff = make_pair_law(steel, nylon, pair, kt);
  EXPECT_EQ(stiff.rolling_k, 8.0 * stiff.g_eff);
  EXPECT_EQ(stiff.rolling_c, 0.6 * std::sqrt(stiff.rolling_k));
  scene::ContactModel clip;
  clip.tail = scene::Tail::clip;
  const PairLaw clipped = make_pair_law(steel, nylon, pair, clip);
  EXPECT_NEAR(clipped.gamma_n / law.gamma_n, 0.180856 / 0.160493, 2e-5);
}

}  // namespace
}  // namespace repose::dem
