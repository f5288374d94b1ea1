#include <gtest/gtest.h>

#include "small_cases.hpp"

namespace repose::dem {
namespace {

struct Rebound {
  double vx, vz, w;  // w about y
};

/// A sphere hits the rigid plane z = 0 with velocity (vx, 0, -vn) and spin w about y.
Rebound impact(OneMaterial material, double radius, double vx, double vn, double w,
               double steps = 20000.0) {
  material.wall_stiffness = 1e9;
  scene::Case c = empty_case(material);
  c.walls = {floor_plane()};
  const double e_eff =
      material.youngs_modulus / (2.0 * (1.0 - material.poissons_ratio * material.poissons_ratio));
  const double duration =
      hertz_impact(e_eff, radius, sphere_mass(radius, material.density), vn).duration;
  c.particles = {grain(radius, {0, 0, radius * (1.0 + 1e-9)}, {vx, 0, -vn}, {0, w, 0})};
  Simulation sim(c, {.time_step_s = duration / steps});
  sim.step(static_cast<std::int64_t>(1.5 * steps));
  while (sim.contacts() > 0) sim.step(1000);
  const Sphere s = sim.spheres()[0];
  return {s.velocity.x(), s.velocity.z(), s.angular_velocity.y()};
}

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(ObliqueImpact, SlidingBranchMatchesRigidBodyTheory) {
  // [Chung2011, test 4]: e_t = 1 - mu (1 + e) / tan(angle), w = 2.5 mu (1 + e) v cos(angle) / R.
  // The short spans of sticking at the first and last touch change both by less than 1e-4.
  const OneMaterial alumina{.density = 4000.0,
                            .youngs_modulus = 380e9,
                            .poissons_ratio = 0.23,
                            .restitution = 0.98,
                            .mu_s = 0.092};
  for (double degrees : {40.0, 50.0, 60.0, 70.0, 80.0}) {
    const double vn = 3.9 * std::cos(degrees * kDegree);
    const double vx = 3.9 * std::sin(degrees * kDegree);
    const Rebound out = impact(alumina, 0.0025, vx, vn, 0.0);
    EXPECT_NEAR(out.vz, 0.98 * vn, 2e-4 * vn);
    EXPECT_NEAR(out.vx / vx, 1.0 - 0.092 * 1.98 / std::tan(degrees * kDegree), 2e-4) << degrees;
    EXPECT_NEAR(out.w, 2.5 * 0.092 * 1.98 * vn / 0.0025, 2e-3 * out.w) << degrees;
  }
}

TEST(ObliqueImpact, AgreesWithAnIndependentIntegrationInAllBranches) {
  // [Chung2011, test 4] with this law, integrated by another program with 1e5 steps a contact:
  // angle from the normal, tangential restitution (4 digits), spin (2 decimals), rebound angle.
  struct Row {
    double degrees, e_t, w, rebound;
  };
  const OneMaterial alumina{.density = 4000.0,
                            .youngs_modulus = 380e9,
                            .poissons_ratio = 0.23,
                            .restitution = 0.98,
                            .mu_s = 0.092};
  for (const Row& row : {Row{2, 0.9852, 2.02, 1.935}, Row{10, 0.7007, 202.38, -0.478},
                         Row{20, 0.6218, 503.74, -6.826}, Row{30, 0.6845, 614.54, -3.486},
                         Row{60, 0.8948, 355.00, 48.165}, Row{85, 0.9841, 61.92, 84.812}}) {
    const double vn = 3.9 * std::cos(row.degrees * kDegree);
    const double vx = 3.9 * std::sin(row.degrees * kDegree);
    const Rebound out = impact(alumina, 0.0025, vx, vn, 0.0);
    EXPECT_NEAR(out.vx / vx, row.e_t, 6e-4) << row.degrees;
    EXPECT_NEAR(out.w, row.w, 0.3 + 1e-3 * row.w) << row.degrees;
    const double at_surface = out.vx - 0.0025 * out.w;
    EXPECT_NEAR(std::atan(at_surface / out.vz) / kDegree, row.rebound, 0.05) << row.degrees;
  }
}

TEST(ObliqueImpact, OfElasticSpheresMatchesTheScaledReference) {
  // [Chung2011, test 5]: psi1 = v_t/(mu v_n) before, psi2 at the contact point after, R w/(mu v_n);
  // by the same independent integration. In full sliding psi2 = psi1 - 7, R w = 5 mu v_n.
  struct Row {
    double psi1, psi2, spin;
  };
  const OneMaterial steel{.density = 7850.0,
                          .youngs_modulus = 208e9,
                          .poissons_ratio = 0.3,
                          .restitution = 1.0,
                          .mu_s = 0.3};
  const double r = 1e-5;
  const double vn = 5.0;
  for (const Row& row :
       {Row{1.0, 0.6532, 0.2475}, Row{3.0, -1.0191, 2.8683}, Row{5.0, -1.4407, 4.5969},
        Row{8.0, 1.0132, 4.9868}, Row{12.0, 5.0132, 4.9868}}) {
    const Rebound out = impact(steel, r, row.psi1 * 0.3 * vn, vn, 0.0);
    EXPECT_NEAR((out.vx - r * out.w) / (0.3 * vn), row.psi2, 2e-3) << row.psi1;
    EXPECT_NEAR(r * out.w / (0.3 * vn), row.spin, 2e-3) << row.psi1;
  }
}

TEST(ObliqueImpact, OfASpinningSphereMatchesTheReference) {
  // [Chung2011, test 6]: R = 0.1 m, v_n = 0.2 m/s, spin R w = 0.2 tan(angle); spin and speed after.
  struct Row {
    double degrees, w, vt;
  };
  const OneMaterial aluminium{.density = 2700.0,
                              .youngs_modulus = 70e9,
                              .poissons_ratio = 0.33,
                              .restitution = 0.5,
                              .mu_s = 0.4};
  for (const Row& row : {Row{10, 0.1084, 0.00977}, Row{45, 0.5418, 0.05834},
                         Row{60, 0.8849, 0.10319}, Row{80, 7.8279, 0.14061}}) {
    const Rebound out = impact(aluminium, 0.1, 0.0, 0.2, 2.0 * std::tan(row.degrees * kDegree));
    EXPECT_NEAR(std::abs(out.w), row.w, 1e-3 * row.w + 1e-3) << row.degrees;
    EXPECT_NEAR(std::abs(out.vx), row.vt, 2e-3 * row.vt + 2e-5) << row.degrees;
  }
}

TEST(ObliqueImpact, OppositeSpinsOfEqualSpheresLeaveNoTangentialForce) {
  // [Chung2011, test 7]: the surfaces move together, so spins stay and nobody is deflected.
  scene::Case c = empty_case({.restitution = 0.5, .mu_s = 0.4});
  c.particles = {grain(0.1, {-0.1001, 0, 0}, {0.2, 0, 0}, {0, 3, 0}),
                 grain(0.1, {0.1001, 0, 0}, {-0.2, 0, 0}, {0, -3, 0})};
  Simulation sim(c);
  while (sim.time_s() < 0.02) sim.step();
  const auto spheres = sim.spheres();
  EXPECT_NEAR(spheres[0].velocity.x(), -0.1, 2e-3);
  EXPECT_EQ(spheres[0].velocity.z(), 0.0);
  EXPECT_EQ(spheres[0].angular_velocity.y(), 3.0);
  EXPECT_EQ(spheres[1].angular_velocity.y(), -3.0);
}

}  // namespace
}  // namespace repose::dem
