// Parameter spaces: scales, ties, and what they refuse.
#include "repose/base/parameter_space.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/toml.hpp"

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

TEST(ParameterSpace, GivesWholeNumbersAndLevelsEqualSharesOfTheUnitInterval) {
  const ParameterSpace space(
      {{.name = "layers", .lower = 2, .upper = 6, .kind = ParameterKind::integer},
       {.name = "mesh", .kind = ParameterKind::levels, .levels = {0.1, 0.5}},
       {.name = "mode",
        .kind = ParameterKind::categorical,
        .categories = {"layered", "mixed", "reverse"}}});
  EXPECT_EQ(level_count(space.parameters()[0]), 5u);
  EXPECT_EQ(space.parameters()[1].upper, 0.5);
  std::vector<int> counts(5, 0);
  for (int i = 0; i < 1000; ++i) {
    const double u = (i + 0.5) / 1000;
    const Vector x = space.from_unit(Vector::Constant(3, u));
    ++counts[static_cast<std::size_t>(x[0]) - 2];
    EXPECT_EQ(x[1], u < 0.5 ? 0.1 : 0.5);
    EXPECT_EQ(x[2], std::floor(3 * u));
  }
  EXPECT_EQ(counts, std::vector<int>(5, 200));
  EXPECT_EQ(space.from_unit(Vector::Zero(3)), Eigen::Vector3d(2, 0.1, 0));
  EXPECT_EQ(space.from_unit(Vector::Ones(3)), Eigen::Vector3d(6, 0.5, 2));
}

TEST(ParameterSpace, ReturnsEveryWholeNumberAndLevelFromItsPlace) {
  std::vector<double> levels;
  for (int i = 0; i < 37; ++i) levels.push_back(i * i);
  const Parameter list{
      .name = "a", .upper = 36 * 36, .kind = ParameterKind::levels, .levels = levels};
  for (const double level : levels) EXPECT_EQ(natural_value(list, unit_value(list, level)), level);
  for (const Scale scale : {Scale::linear, Scale::log})
    for (const double upper : {2.0, 10.0, 997.0, 1e9}) {
      const Parameter p{
          .name = "n", .lower = 1, .upper = upper, .scale = scale, .kind = ParameterKind::integer};
      for (double v = 1; v <= upper; v += std::max(1.0, std::floor(upper / 1000)))
        EXPECT_EQ(natural_value(p, unit_value(p, v)), v) << upper;
      EXPECT_EQ(natural_value(p, 0.0), 1.0);
      EXPECT_EQ(natural_value(p, 1.0), upper);
    }
}

TEST(ParameterSpace, SaysWhichConstraintsAPointBreaksAlsoOfTiedAndFixedParameters) {
  const ParameterSpace space(
      {{.name = "a"}, {.name = "b"}}, {{"c", 0.5}}, {{"m", {"b", "c"}}},
      {{.name = "order", .coefficients = {{"a", 1.0}, {"m", -1.0}}, .upper = 0.0},
       {.name = "total", .coefficients = {{"a", 1.0}, {"b", 1.0}}, .lower = 0.3}});
  EXPECT_TRUE(space.obeys_constraints(Eigen::Vector2d(0.5, 0.5)));  // on the bound: m = 0.5
  EXPECT_TRUE(space.obeys_constraints(Eigen::Vector2d(0.1, 0.2)));  // 0.1 + 0.2 > 0.3 by rounding
  EXPECT_TRUE(space.obeys_constraints(Eigen::Vector2d(0.2, 0.1 - 1e-12)));
  EXPECT_FALSE(space.obeys_constraints(Eigen::Vector2d(0.2, 0.0999)));
  const auto broken = space.broken_constraints(Eigen::Vector2d(0.6, 0.5));
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_EQ(broken[0], "order: 1 a - 1 m = 0.1 is above 0");
  EXPECT_EQ(space.broken_constraints(Eigen::Vector2d(0.0, 0.0))[0],
            "total: 1 a + 1 b = 0 is below 0.3");
}

TEST(ParameterSpace, IsReadFromTomlWithAllItsParts) {
  const auto root = TomlTable::parse(R"(
[parameters]
mu_s = { lower = 0.3, upper = 0.9 }
layers = { lower = 1, upper = 5, integer = true }
mesh = { levels = [0.1, 0.2], unit = "m" }
mode = { categories = ["layered", "mixed"] }
[fixed]
mu_r = 0.2
[ties]
mu_p = ["mu_s", "mu_r"]
[constraints]
slope = { coefficients = { mu_s = 1, mesh = -2.5 }, upper = 0.25 }
)",
                                     "factors.toml");
  const ParameterSpace space = read_parameter_space(root);
  root.refuse_unknown_keys();
  EXPECT_EQ(space.names(), (std::vector<std::string>{"mu_s", "layers", "mesh", "mode"}));
  EXPECT_EQ(space.parameters()[1].kind, ParameterKind::integer);
  EXPECT_EQ(space.parameters()[2].unit, "m");
  EXPECT_EQ(space.parameters()[3].categories[1], "mixed");
  EXPECT_DOUBLE_EQ(space.complete(Eigen::Vector4d(0.4, 1, 0.1, 0)).at("mu_p"), 0.3);
  EXPECT_TRUE(space.obeys_constraints(Eigen::Vector4d(0.5, 1, 0.1, 0)));
  EXPECT_FALSE(space.obeys_constraints(Eigen::Vector4d(0.51, 1, 0.1, 0)));
}

TEST(ParameterSpace, RefusesTomlWithFileAndLine) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      const auto root = TomlTable::parse("[parameters]\n" + text, "f.toml");
      static_cast<void>(read_parameter_space(root));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto expect = [&](const std::string& text, const std::string& line,
                          const std::string& reason) {
    const auto said = message(text);
    EXPECT_EQ(said.rfind("f.toml:" + line, 0), 0u) << said;
    EXPECT_NE(said.find(reason), std::string::npos) << said;
  };
  expect("a = { lower = 2, upper = 1 }", "2", "not below upper = 1");
  expect("a = { lower = 0.5, upper = 2, integer = true }", "2", "must be whole");
  expect("a = { levels = [1] }", "2", "1 levels");
  expect("a = { levels = [1, 3, 2] }", "2", "must be finite and ascend");
  expect("a = { categories = [\"x\", \"x\"] }", "2", "different names");
  expect("", "1", "there are no parameters");
  const std::string ab = "a = { lower = 0, upper = 1 }\nb = { categories = [\"x\", \"y\"] }\n";
  expect(ab + "[fixed]\na = 1\n", "1", "given twice");
  expect(ab + "[ties]\nc = [\"b\"]\n", "1", "a mean needs numbers");
  const std::string bound = ab + "[constraints]\ns = ";
  expect(bound + "{ coefficients = { z = 1 }, upper = 1 }", "5", "z is no parameter");
  expect(bound + "{ coefficients = { b = 1 }, upper = 1 }", "5", "names instead of numbers");
  expect(bound + "{ coefficients = { a = 0 }, upper = 1 }", "5", "no coefficient differs from 0");
  expect(bound + "{ coefficients = { a = 1 } }", "5", "it bounds nothing");
  expect(bound + "{ coefficients = { a = 1 }, lower = 2, upper = 1 }", "5", "nothing between");
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
