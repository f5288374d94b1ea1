// Parameter spaces: scales, ties, and what they refuse.
#include "repose/base/parameter_space.hpp"

#include <gtest/gtest.h>

#include "repose/base/error.hpp"

namespace repose {
namespace {

ParameterSpace example() {
  return ParameterSpace(
      {{.name = "mu_s_pp", .lower = 0.2, .upper = 1.0},
       {.name = "stiffness", .lower = 1e6, .upper = 1e8, .scale = Scale::log}},
      {{"mu_s_ss", 0.5}},
      {{"mean_of_tied", {"mu_s_ps", "mu_s_pp"}}, {"mu_s_ps", {"mu_s_pp", "mu_s_ss"}}});
}

TEST(ParameterSpace, MapsTheUnitCubeThroughScalesAndBack) {
  const auto space = example();
  const Vector x = space.from_unit(Eigen::Vector2d(0.25, 0.5));
  EXPECT_DOUBLE_EQ(x[0], 0.4);
  EXPECT_NEAR(x[1], 1e7, 1e7 * 1e-14);
  const Vector u = space.to_unit(x);
  EXPECT_NEAR(u[0], 0.25, 1e-15);
  EXPECT_NEAR(u[1], 0.5, 1e-15);
  EXPECT_EQ(space.from_unit(Eigen::Vector2d(1.0, 1.0))[1], 1e8);  // bounds are exact
}

TEST(ParameterSpace, ComputesTiesInWhateverOrderTheyAreGiven) {
  const auto values = example().complete(Eigen::Vector2d(0.7, 1e7));
  EXPECT_DOUBLE_EQ(values.at("mu_s_ps"), 0.6);
  EXPECT_DOUBLE_EQ(values.at("mean_of_tied"), 0.65);
  EXPECT_DOUBLE_EQ(values.at("mu_s_ss"), 0.5);
}

TEST(ParameterSpace, RefusesWhatCannotBeAndNamesIt) {
  const auto message = [](auto make) -> std::string {
    try {
      make();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message([] {
              ParameterSpace({{.name = "a", .lower = 2, .upper = 1}});
            }).find("lower = 2, upper = 1"),
            std::string::npos);
  EXPECT_NE(message([] {
              ParameterSpace({{.name = "a", .lower = 0, .upper = 1, .scale = Scale::log}});
            }).find("logarithmic"),
            std::string::npos);
  EXPECT_NE(message([] {
              ParameterSpace({{.name = "a"}}, {{"a", 1.0}});
            }).find("twice"),
            std::string::npos);
  EXPECT_NE(message([] {
              ParameterSpace({}, {}, {{"x", {"y"}}, {"y", {"x"}}});
            }).find("neither"),
            std::string::npos);
}

}  // namespace
}  // namespace repose
