// Linear constraints, ties and whole numbers.
#include "repose/opt/feasible_set.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

FeasibleSet example() {
  return {{Vector{{0.0, -1.5}}, Vector{{2.0, 3.5}}}, {{"sum", Vector{{1.0, 2.0}}, 3.0}}, {1}};
}

TEST(FeasibleSet, RoundsWholeCoordinatesIntoTheBox) {
  EXPECT_EQ(rounded(Vector{{0.3, 1.4}}, example()), (Vector{{0.3, 1.0}}));
  EXPECT_EQ(rounded(Vector{{-1.0, 9.0}}, example()), (Vector{{0.0, 3.0}}));   // 3.5 is the bound
  EXPECT_EQ(rounded(Vector{{2.5, -9.0}}, example()), (Vector{{2.0, -1.0}}));  // -1.5 is the bound
}

TEST(FeasibleSet, MeasuresViolationInRangesOfTheConstraint) {
  EXPECT_EQ(violation(Vector{{1.0, 1.0}}, example()), 0.0);  // on it
  // (2 + 2*2 - 3) over 1*2 + 2*5.
  EXPECT_NEAR(violation(Vector{{2.0, 2.0}}, example()), 3.0 / 12.0, 1e-15);
  EXPECT_EQ(violation(Vector{{0.1 * 3, (3.0 - 0.1 * 3) / 2.0}}, example()),
            0.0);  // but for rounding
}

void expect_refused(const FeasibleSet& set, const char* what) {
  try {
    check_feasible_set(set);
    FAIL() << what;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  }
}

TEST(FeasibleSet, RefusesWhatNoPointObeys) {
  check_feasible_set(example());
  FeasibleSet set = example();
  set.inequalities[0].bound = -4.0;  // the least is 0 - 3
  expect_refused(set, "constraint sum: no point of the box is below -4; the smallest value is -3");
  set = example();
  set.inequalities[0].coefficients = Vector::Ones(3);
  expect_refused(set, "constraint sum has 3 coefficients; 2 finite ones");
  set = example();
  set.whole = {2};
  expect_refused(set, "coordinate 3 is to be a whole number; there are 2");
  set = example();
  set.bounds.lower[1] = 3.2;
  expect_refused(set, "holds no whole number");
}

// x2 = 1 - x0 in [0.2, 2] asks for x0 <= 0.8; x3 = 2 x0 in [0.3, 9] for x0 >= 0.15.
FeasibleSet tied() {
  return {{Vector{{0.0, 0.0, 0.2, 0.3}}, Vector{{1.0, 1.0, 2.0, 9.0}}},
          {},
          {},
          {{2, 0, -1.0, 1.0}, {3, 0, 2.0, 0.0}}};
}

TEST(LinearTies, NarrowTheBoundsOfTheLeader) {
  check_feasible_set(tied());
  const Bounds bounds = narrowed_bounds(tied());
  EXPECT_EQ(bounds.lower, (Vector{{0.15, 0.0, 0.2, 0.3}}));
  EXPECT_EQ(bounds.upper, (Vector{{0.8, 1.0, 2.0, 9.0}}));
  EXPECT_EQ(free_coordinates(tied()), (std::vector<Eigen::Index>{0, 1}));
}

TEST(LinearTies, AreObeyedByAnyRoundedPoint) {
  const FeasibleSet set = tied();
  for (double x = -1.0; x < 2.0; x += 0.037) {
    const Vector p = rounded(Vector{{x, 0.5, 17.0, -3.0}}, set);
    EXPECT_EQ(violation(p, set), 0.0) << p.transpose();
    EXPECT_EQ(p, project(p, set.bounds));
  }
  EXPECT_EQ(rounded(Vector{{0.5, 0.5, 0.0, 0.0}}, set), (Vector{{0.5, 0.5, 0.5, 1.0}}));
}

TEST(LinearTies, AreMeasuredInRangesOfTheFollower) {
  EXPECT_NEAR(violation(Vector{{0.5, 0.5, 0.7, 1.0}}, tied()), 0.2 / 1.8, 1e-15);
}

// x0 + x3 = 3 x0 with x0 >= 0.15: nothing is below 0.45, though the box alone reaches 0.3.
TEST(LinearTies, CountInConstraintsThatNoPointObeys) {
  FeasibleSet set = tied();
  set.inequalities = {{"sum", Vector{{1.0, 0.0, 0.0, 1.0}}, 0.46}};
  check_feasible_set(set);
  set.inequalities[0].bound = 0.44;
  expect_refused(set, "constraint sum: no point of the box is below 0.44");
}

TEST(LinearTies, AreRefusedByNameWhereTheyAreNone) {
  const auto with = [](LinearTie tie) {
    FeasibleSet set = tied();
    set.ties.push_back(tie);
    return set;
  };
  expect_refused(with({4, 0}), "a tie names coordinate 5; there are 4");
  expect_refused(with({1, 1}), "coordinate 2 is tied to coordinate 2, which is itself");
  expect_refused(with({1, 0, 0.0}), "the ratio not 0");
  expect_refused(with({1, 0, 1.0, std::numeric_limits<double>::infinity()}), "must be finite");
  expect_refused(with({2, 1}), "coordinate 3 is tied to coordinate 1, and follows another one too");
  expect_refused(with({1, 2}), "coordinate 2 is tied to coordinate 3, which follows another one");
  expect_refused(with({1, 0, 1.0, 0.9}),
                 "coordinate 2 is tied to coordinate 1 as 0.9 + 1 x and lies in [0, 1], so that "
                 "the latter must");
  FeasibleSet set = with({1, 0});
  set.whole = {1};
  expect_refused(set, "which need not be whole");
  set.whole = {0, 1};  // x0 in [0.15, 0.8]
  expect_refused(set, "coordinate 1 lies in [0.15, 0.8], which holds no whole number");
}

}  // namespace
}  // namespace repose::opt
