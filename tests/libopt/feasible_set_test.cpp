// Linear constraints and whole numbers.
#include "repose/opt/feasible_set.hpp"

#include <gtest/gtest.h>

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

TEST(FeasibleSet, RefusesWhatNoPointObeys) {
  check_feasible_set(example());
  const auto expect_refused = [](FeasibleSet set, const char* what) {
    try {
      check_feasible_set(set);
      FAIL() << what;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  };
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

}  // namespace
}  // namespace repose::opt
