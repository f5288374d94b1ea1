#include <fmt/format.h>
#include <gtest/gtest.h>

#include "two_bodies.hpp"

namespace repose::dem {
namespace {

const OneMaterial kAluminium{.density = 2700.0,
                             .youngs_modulus = 70e9,
                             .poissons_ratio = 0.33,
                             .restitution = 0.5,
                             .mu_s = 0.4,
                             .wall_stiffness = 1e9};
scene::ContactModel clip() {
  scene::ContactModel model;
  model.tail = scene::Tail::clip;
  return model;
}

/// The contact that both bodies are in, from the first to the last touch.
template <class Each>
void until_separated(TwoBodies& two, Each&& each) {
  bool touched = false;
  for (int k = 0; k < 10'000'000; ++k) {
    two.step();
    if (touched && !two.touching) return;
    touched = touched || two.touching;
    each(two);
  }
  ADD_FAILURE() << "the bodies stay together";
}

TEST(ClippedTail, NeverAttractsAndNeverExceedsFriction) {
  for (double speed : {0.0, 0.05, 0.3, 2.0}) {
    TwoBodies two = impact_of(kAluminium, clip(), 0.1, {speed, 0, -0.2}, {0, 3, 1}, 3000);
    double deepest = 0.0;
    until_separated(two, [&](const TwoBodies& now) {
      EXPECT_GE(now.force.normal, 0.0);
      EXPECT_LE(now.force.tangential.norm(), 0.4 * now.force.normal * (1.0 + 1e-12));
      deepest = std::max(deepest, now.force.normal);
    });
    EXPECT_GT(deepest, 0.0);
    EXPECT_NEAR(two.a.v.z(), 0.1, 1e-3 * 0.2) << speed;
  }
}

TEST(KeptTail, AttractsBeforeSeparation) {
  TwoBodies two = impact_of(kAluminium, {}, 0.1, {0, 0, -0.2}, Vec3::Zero(), 3000);
  double lowest = 0.0;
  until_separated(two, [&](const TwoBodies& now) { lowest = std::min(lowest, now.force.normal); });
  EXPECT_LT(lowest, 0.0);
  EXPECT_NEAR(two.a.v.z(), 0.1, 1e-3 * 0.2);
}

/// What enters equals what is left and lost, to the order of the time step.
double ledger_error(const OneMaterial& m, const scene::ContactModel& model, double steps) {
  TwoBodies two = impact_of(m, model, 0.1, {0.15, 0.05, -0.2}, {1.0, 2.0, 0.0}, steps);
  const double start = two.kinetic_j();
  double worst = 0.0;
  until_separated(two, [&](const TwoBodies& now) {
    const double balance = now.kinetic_j() + now.energies.stored_j() + now.lost_j - start;
    worst = std::max(worst, std::abs(balance));
  });
  worst = std::max(worst, std::abs(two.kinetic_j() + two.lost_j - start));
  return worst / start;
}

TEST(Energies, BalanceToTheOrderOfTheTimeStepInEveryModel) {
  OneMaterial m = kAluminium;
  m.mu_r = 0.1;
  for (scene::Tail tail : {scene::Tail::keep, scene::Tail::clip})
    for (scene::RollingModel rolling : {scene::RollingModel::c, scene::RollingModel::a})
      for (scene::RollingStiffness stiffness :
           {scene::RollingStiffness::ai, scene::RollingStiffness::kt})
        for (scene::Compatibility compatibility :
             {scene::Compatibility::none, scene::Compatibility::liggghts}) {
          const scene::ContactModel model{tail, rolling, stiffness, compatibility};
          const double coarse = ledger_error(m, model, 500);
          const double fine = ledger_error(m, model, 4000);
          const std::string which =
              fmt::format("tail {} rolling {} stiffness {} compatibility {}",
                          static_cast<int>(tail), static_cast<int>(rolling),
                          static_cast<int>(stiffness), static_cast<int>(compatibility));
          EXPECT_LT(fine, 5.0 / 4000) << which;
          EXPECT_LT(fine, coarse / 5.0) << which;
        }
}

TEST(Energies, OfAnElasticFrictionlessContactAreNormalOnly) {
  OneMaterial m = kAluminium;
  m.restitution = 1.0;
  m.mu_s = 0.0;
  TwoBodies two = impact_of(m, {}, 0.1, {0, 0, -0.2}, Vec3::Zero(), 1000);
  double largest = 0.0;
  until_separated(two, [&](const TwoBodies& now) {
    largest = std::max(largest, now.energies.normal_j);
    EXPECT_EQ(now.energies.lost_w(), 0.0);
    EXPECT_EQ(now.energies.stored_j(), now.energies.normal_j);
  });
  EXPECT_NEAR(largest, 0.5 * sphere_mass(0.1, 2700) * 0.04, 1e-4);
}

TEST(Cohesion, ActsOnTheCircleOfIntersection) {
  // Two spheres: the circle from the right-angled triangles with both radii.
  for (double second : {0.003, 0.01, 1.0})
    for (double overlap : {1e-6, 1e-4, 1e-3}) {
      const double first = 0.005;
      const double distance = first + second - overlap;
      const double x = (distance * distance + first * first - second * second) / (2.0 * distance);
      const double area = std::numbers::pi * (first + x) * (first - x);
      EXPECT_NEAR(cohesion_area(first * second / (first + second), overlap, 1.0 / distance), area,
                  1e-9 * area + 1e-15);
    }
  EXPECT_NEAR(cohesion_area(0.005, 1e-4, 0.0), std::numbers::pi * (0.01 * 1e-4 - 1e-8), 1e-18);
}

TEST(Cohesion, IsConservativeAndNotInTheFrictionLimit) {
  // A plane: the work over d is k pi (R d^2 - d^3/3).
  PairLaw law;
  law.e_eff = 1e7;
  law.g_eff = 1e6;
  law.mu_s = 0.5;
  law.cohesion = 1e5;
  ContactKinematics now{-Vec3::UnitZ(), -Vec3::UnitZ(), 1e-4, 0.0, Vec3::Zero(), Vec3::Zero()};
  now.velocity = {1.0, 0.0, 0.0};
  ContactHistory history;
  ContactEnergies energies;
  const ContactForce f =
      hertz_mindlin({}, law, sphere_wall(0.005, 1e-3), now, 1e-3, history, energies);
  const double hertz = 4.0 / 3.0 * 1e7 * std::sqrt(0.005) * 1e-6;
  EXPECT_NEAR(f.normal, hertz, 1e-12 * hertz);
  EXPECT_NEAR(f.force.z(), hertz - 1e5 * cohesion_area(0.005, 1e-4, 0.0), 1e-12 * hertz);
  EXPECT_NEAR(f.tangential.norm(), 0.5 * hertz, 1e-12 * hertz);
  const double work = 1e5 * std::numbers::pi * (0.005 * 1e-8 - 1e-12 / 3.0);
  EXPECT_NEAR(energies.normal_j, 0.4 * hertz * 1e-4 - work, 1e-12 * work);
}

TEST(RollingTypeA, StopsASpinWithoutTurningItBack) {
  OneMaterial m{.mu_s = 0.0, .mu_r = 0.1};
  scene::ContactModel model;
  model.rolling = scene::RollingModel::a;
  TwoBodies two = impact_of(m, model, 0.01, {0, 0, -0.01}, Vec3::Zero(), 1000);
  two.dt = 1e-5;
  const double weight = sphere_mass(0.01, m.density) * 9.81;
  two.a.v.setZero();
  two.a.x.z() -= hertz_overlap(two.law.e_eff, 0.01, weight);
  two.gravity = {0, 0, -9.81};
  two.wa.w = {3.0, -4.0, 2.0};
  // Constant torque: |w| falls by mu_r R F_n / I a second, so it stands after I |w|/(mu_r R F_n).
  const double inertia = 0.4 * sphere_mass(0.01, m.density) * 1e-4;
  const double stop = inertia * 5.0 / (0.1 * 0.01 * weight);
  double before = 5.0;
  for (double t = 0.0; t < 0.99 * stop; t += two.dt) {
    two.step();
    const double now = std::hypot(two.wa.w.x(), two.wa.w.y());
    EXPECT_LE(now, before);
    EXPECT_NEAR(two.wa.w.x() * 4.0, -two.wa.w.y() * 3.0, 1e-9);
    before = now;
  }
  EXPECT_GT(before, 0.005);
  EXPECT_LT(before, 0.1);
  for (double t = 0.0; t < 0.02 * stop; t += two.dt) two.step();
  EXPECT_LT(std::hypot(two.wa.w.x(), two.wa.w.y()), 1e-12);
  EXPECT_EQ(two.wa.w.z(), 2.0);  // twisting is not rolling
}

TEST(History, KeepsItsLengthWhenTheContactTurnsUnlessCompatible) {
  PairLaw law;
  law.e_eff = law.g_eff = 1e7;
  law.mu_s = 1e6;
  law.mu_r = 1e6;
  law.rolling_k = 1e3;
  const Vec3 half = Vec3(0.0, std::sin(0.1), std::cos(0.1));
  ContactHistory history{{0.0, 1e-5, 0.0}, {1e-3, 1e-3, 0.0}};
  const ContactKinematics turned{
      {0.0, std::sin(0.2), std::cos(0.2)}, half, 1e-4, 100.0, Vec3::Zero(), Vec3::Zero()};
  ContactHistory synchronised = history;
  hertz_mindlin({}, law, sphere_wall(0.005, 1e-3), turned, 1e-5, synchronised);
  EXPECT_NEAR(synchronised.slip.norm(), 1e-5, 1e-19);
  EXPECT_NEAR(synchronised.rolling.norm(), std::sqrt(2.0) * 1e-3, 1e-17);
  EXPECT_NEAR(synchronised.slip.dot(turned.normal), 0.0, 1e-20);
  EXPECT_NEAR(synchronised.slip.y(), 1e-5 * std::cos(0.2), 1e-19);

  scene::ContactModel model;
  model.compatibility = scene::Compatibility::liggghts;
  ContactKinematics at_once = turned;
  at_once.normal_half = turned.normal;
  hertz_mindlin(model, law, sphere_wall(0.005, 1e-3), at_once, 1e-5, history);
  EXPECT_NEAR(history.slip.norm(), 1e-5 * std::cos(0.2), 1e-19);
  EXPECT_EQ(history.rolling, Vec3(1e-3, 1e-3, 0.0));
}

TEST(ContactState, SaysWhetherFrictionIsMobilisedAndChangesNothing) {
  OneMaterial m = kAluminium;
  m.restitution = 0.9;
  for (const auto& [speed, slides] : {std::pair{0.001, false}, std::pair{2.0, true}}) {
    TwoBodies two = impact_of(m, {}, 0.1, {speed, 0, -0.2}, Vec3::Zero(), 2000);
    for (int k = 0; k < 1000; ++k) two.step();  // half of the contact
    const ContactHistory before = two.history;
    const ContactState state =
        contact_state(two.model, two.law, two.bodies(), two.kinematics(), two.history);
    EXPECT_EQ(state.sliding, slides);
    EXPECT_EQ(two.history.slip, before.slip);
    EXPECT_EQ(state.overlap_m, two.a.radius - two.a.x.z());
    EXPECT_GT(state.normal_force_n, 0.0);
  }
}

TEST(History, TurnsWithAContactThatSpinsAboutItsNormal) {
  // Two bodies that spin together about their line of centres, wound up in sliding and rolling: in
  // a quarter of a turn both springs turn with them, and keep their length.
  const PairLaw law = make_pair_law({"a", 2500.0, 1e8, 0.25}, {"a", 2500.0, 1e8, 0.25},
                                    {"a", "a", 0.5, 10.0, 10.0, 0.3}, {});
  const ContactBodies bodies = sphere_sphere(0.01, 0.01, 0.01, 0.01);
  const Vec3 normal = Vec3(1, 2, -2) / 3.0;
  const Vec3 across = Vec3(2, 1, 2) / 3.0;  // normal x across is the third direction
  ContactKinematics now;
  now.normal = now.normal_half = normal;
  now.overlap = 1e-4;
  now.inv_distance = 1.0 / 0.02;
  now.velocity.setZero();
  now.spin.setZero();
  now.turning = 50.0;
  const int steps = 1000;
  const double dt = 0.5 * std::numbers::pi / now.turning / steps;
  ContactHistory history{1e-6 * across, 1e-7 * across};
  for (int k = 0; k < steps; ++k) hertz_mindlin({}, law, bodies, now, dt, history);
  // The angle of a step is off by its fifth power over 120, the length by its fourth over 24.
  EXPECT_LT((history.slip / 1e-6 - cross(normal, across)).norm(), 1e-9);
  EXPECT_LT((history.rolling / 1e-7 - cross(normal, across)).norm(), 1e-9);
  scene::ContactModel liggghts;
  liggghts.compatibility = scene::Compatibility::liggghts;
  history = {1e-6 * across, 1e-7 * across};
  hertz_mindlin(liggghts, law, bodies, now, dt, history);
  EXPECT_LT((history.slip / 1e-6 - across).norm(), 1e-12);
}

}  // namespace
}  // namespace repose::dem
