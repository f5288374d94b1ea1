// The short forms of all checks; dem_validation writes the long ones into docs/validation/dem.md.
#include <gtest/gtest.h>

#include "check.hpp"

namespace repose::physics {
namespace {

void expect_all(const std::vector<Check>& checks) {
  EXPECT_FALSE(checks.empty());
  for (const Check& c : checks)
    EXPECT_TRUE(c.passed()) << c.requirement << ": " << c.result << ' ' << c.unit << ", reference "
                            << c.reference << ", tolerance " << c.tolerance;
}

TEST(Physics, ChungAndOoisTestsMatchClosedFormsAndTables) {
  expect_all(chung_ooi(Extent::quick));
}
TEST(Physics, RestitutionHoldsAtEverySpeedInBothModes) {
  expect_all(restitution(Extent::quick));
}
TEST(Physics, NoObliqueImpactGainsEnergy) {
  expect_all(oblique_impacts(Extent::quick));
}
TEST(Physics, SlidingAndRollingMatchTheory) {
  expect_all(sliding_and_rolling(Extent::quick));
}
TEST(Physics, AContactDoesNotNoticeThatItTurns) {
  expect_all(rotating_frame(Extent::quick));
}
TEST(Physics, AngularMomentumIsConserved) {
  expect_all(angular_momentum(Extent::quick));
}
TEST(Physics, AnElasticGasKeepsItsEnergy) {
  expect_all(elastic_gas(Extent::quick));
}
TEST(Physics, ErrorsFallWithTheTimeStepAtTheirOrder) {
  expect_all(time_step_order(Extent::quick));
}
TEST(Physics, ASmallGrainIsNotTrappedBetweenLargeOnes) {
  expect_all(size_ratio(Extent::quick));
}
TEST(Physics, ClumpsMatchTheirClosedForms) {
  expect_all(clumps(Extent::quick));
}
TEST(Physics, TrianglesActAsThePrimitivesTheyStandFor) {
  expect_all(meshes(Extent::quick));
}
TEST(Physics, ATurningDrumBalances) {
  expect_all(drums(Extent::quick));
}
TEST(Physics, DischargeFollowsBeverloo) {
  expect_all(beverloo(Extent::quick));
}
TEST(Physics, TheAngleOfReposeRisesWithFriction) {
  expect_all(angle_of_repose(Extent::quick));
}

}  // namespace
}  // namespace repose::physics
