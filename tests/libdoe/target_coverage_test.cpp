// Targets outside the runs of a screening, on responses that are exactly linear.
#include "repose/doe/target_coverage.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random_matrix.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/designs.hpp"

namespace repose::doe {
namespace {

using Position = ResponseCoverage::Position;

/// "angle" = 30 + 2 a - 1 b (+ noise of 0.01), "flow" is chance alone. Three repetitions.
class Coverage : public testing::Test {
 protected:
  Coverage() {
    const Matrix x = definitive_screening_design(6).coded;
    const Vector mean = 30.0 + 2.0 * x.col(0).array() - x.col(1).array();
    const Matrix angle = (0.01 * test::random_matrix(x.rows(), 3, 1)).colwise() + mean;
    screening = screen(x, {"a", "b", "c", "d", "e", "f"}, {"angle", "flow"},
                       {angle, test::random_matrix(x.rows(), 3, 2)});
  }
  TargetCoverage cover(double angle, double tolerance, const std::vector<Parameter>& limits = {},
                       const CoverageOptions& options = {.margin = 0.0}) const {
    return cover_targets(screening, {{"angle", angle, tolerance}}, ranges, limits, options);
  }
  Screening screening;
  ParameterSpace ranges{{{.name = "a", .lower = 0.2, .upper = 0.6},
                         {.name = "b", .lower = 1e6, .upper = 1e8, .scale = Scale::log},
                         {.name = "c"},
                         {.name = "d"},
                         {.name = "e"},
                         {.name = "f"}}};
};

// Runs with |a| = |b| = 1 and a = -b exist: they reach 33 and 27, up to the noise of means.
TEST_F(Coverage, OfATargetWithinTheRunsMovesNothing) {
  const auto coverage = cover(32.0, 5.0);
  EXPECT_EQ(coverage.responses[0].position, Position::inside);
  EXPECT_NEAR(coverage.responses[0].highest, 33.0, 0.05);
  EXPECT_NEAR(coverage.responses[0].lowest, 27.0, 0.05);
  EXPECT_FALSE(coverage.responses[0].stochastic);
  EXPECT_EQ(coverage.ranges[0].upper, 0.6);
  EXPECT_TRUE(coverage.ranges[0].because.empty());
}

TEST_F(Coverage, OfATargetAboveExtendsEachFactorTheWayOfItsEffect) {
  const auto coverage = cover(34.0, 0.5);  // gap 1.5 = (2 + 1) delta, delta 0.5
  EXPECT_EQ(coverage.responses[0].position, Position::above);
  EXPECT_EQ(coverage.responses[0].direction, (std::vector<int>{1, -1, 0, 0, 0, 0}));
  EXPECT_NEAR(coverage.responses[0].gap, 1.5, 0.05);
  EXPECT_NEAR(coverage.responses[0].still_missing, 0.0, 1e-12);
  const double delta = coverage.responses[0].gap / (std::abs(screening.responses[0].effect(0)) +
                                                    std::abs(screening.responses[0].effect(1)));
  EXPECT_NEAR(delta, 0.5, 0.02);
  EXPECT_NEAR(coverage.ranges[0].upper, 0.6 + 0.2 * delta, 1e-12);
  EXPECT_EQ(coverage.ranges[0].lower, 0.2);
  EXPECT_NEAR(coverage.ranges[1].lower, 1e6 * std::pow(10.0, -delta), 1.0);  // half range: a decade
  EXPECT_TRUE(coverage.ranges[1].lower_extended && !coverage.ranges[1].upper_extended);
  EXPECT_EQ(coverage.ranges[0].because, std::vector<std::string>{"angle"});
  EXPECT_EQ(coverage.ranges[2].upper, 1.0);
}

TEST_F(Coverage, OfATargetBelowGoesTheOtherWayWithItsMargin) {
  const auto plain = cover(26.0, 0.0), wide = cover(26.0, 0.0, {}, {.margin = 0.5});
  EXPECT_EQ(plain.responses[0].position, Position::below);
  EXPECT_EQ(plain.responses[0].direction, (std::vector<int>{-1, 1, 0, 0, 0, 0}));
  EXPECT_NEAR(wide.ranges[0].lower - 0.2, 1.5 * (plain.ranges[0].lower - 0.2), 1e-12);
}

TEST_F(Coverage, LeavesTheRestToOthersWhereAFactorMeetsItsLimit) {
  const std::vector<Parameter> limits{{.name = "a", .lower = 0.0, .upper = 0.62}};
  const auto coverage = cover(34.0, 0.0, limits);  // a gives 2 * 0.1, b the remaining 0.8
  EXPECT_EQ(coverage.ranges[0].upper, 0.62);
  EXPECT_TRUE(coverage.ranges[0].at_limit);
  const double rest = coverage.responses[0].gap - 0.1 * screening.responses[0].effect(0);
  const double delta = rest / std::abs(screening.responses[0].effect(1));
  EXPECT_NEAR(coverage.ranges[1].lower, 1e6 * std::pow(10.0, -delta), 1.0);
  EXPECT_NEAR(coverage.responses[0].still_missing, 0.0, 1e-12);
}

TEST_F(Coverage, DoesNotMakeNegativeWhatWasScreenedAtPositiveValues) {
  // a would fall by two half ranges, to -0.2.
  const auto coverage = cover(10.0, 0.0, {}, {.margin = 0.0, .most_half_ranges = 2.0});
  EXPECT_NEAR(coverage.ranges[0].lower, 0.0, 1e-15);
  EXPECT_TRUE(coverage.ranges[0].at_limit);
  const auto allowed = cover(10.0, 0.0, {{.name = "a", .lower = -1.0, .upper = 1.0}},
                             {.margin = 0.0, .most_half_ranges = 2.0});
  EXPECT_LT(allowed.ranges[0].lower, -0.1);
}

// y = 40 + 6 a^2 + 3 b: a matters, but its main effect is noise and says nothing about the way.
TEST_F(Coverage, DoesNotMoveAFactorByTheSignOfAnInsignificantMainEffect) {
  const Matrix x = definitive_screening_design(6).coded;
  const Vector mean = 40.0 + 6.0 * x.col(0).array().square() + 3.0 * x.col(1).array();
  const Matrix y = (0.1 * test::random_matrix(x.rows(), 3, 7)).colwise() + mean;
  const Screening curved = screen(x, {"a", "b", "c", "d", "e", "f"}, {"y"}, {y});
  ASSERT_TRUE(curved.selected[0]);
  const auto coverage = cover_targets(curved, {{"y", 30.0, 0.0}}, ranges);
  EXPECT_EQ(coverage.responses[0].direction[0], 0);
  EXPECT_TRUE(coverage.responses[0].undirected[0]);
  EXPECT_EQ(coverage.responses[0].direction[1], -1);
  EXPECT_EQ(coverage.ranges[0].lower, 0.2);
}

TEST_F(Coverage, SaysWhatIsStillMissingBeyondTheLargestExtension) {
  const auto coverage = cover(40.0, 0.0);  // gap 7, one half range of each gives 3
  EXPECT_NEAR(coverage.responses[0].still_missing, 4.0, 0.1);
  EXPECT_NEAR(coverage.ranges[0].upper, 0.8, 1e-12);
  EXPECT_NEAR(coverage.ranges[1].lower, 1e5, 1e-3);
  EXPECT_FALSE(coverage.ranges[0].at_limit);
}

TEST_F(Coverage, SaysWhichResponseCannotCalibrateAndHasNothingToMove) {
  const auto coverage = cover_targets(screening, {{"flow", 50.0, 0.0}}, ranges);
  EXPECT_TRUE(coverage.responses[0].stochastic);
  EXPECT_EQ(coverage.responses[0].direction, std::vector<int>(6, 0));
  EXPECT_EQ(coverage.responses[0].still_missing, coverage.responses[0].gap);
  EXPECT_EQ(coverage.ranges[0].upper, 0.6);
}

TEST_F(Coverage, RefusesWhatDoesNotFit) {
  EXPECT_THROW(cover_targets(screening, {{"mass", 1.0, 0.0}}, ranges), InputError);
  EXPECT_THROW(cover(NAN, 0.0), InputError);
  EXPECT_THROW(cover(30.0, -1.0), InputError);
  EXPECT_THROW(cover(34.0, 0.0, {{.name = "a", .lower = 0.3, .upper = 0.9}}), InputError);
  EXPECT_THROW(cover(34.0, INFINITY), InputError);
  EXPECT_THROW(cover(34.0, 0.0, {{.name = "A", .lower = 0.0, .upper = 0.9}}), InputError);
  EXPECT_THROW(cover(34.0, 0.0, {}, {.margin = -0.1}), InputError);
  EXPECT_THROW(cover(34.0, 0.0, {}, {.most_half_ranges = 0.0}), InputError);
  EXPECT_THROW(cover_targets(screening, {}, ParameterSpace({{.name = "a"}})), InputError);
}

}  // namespace
}  // namespace repose::doe
