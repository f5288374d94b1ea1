// Selection finds the kernel and the trend that made the data.
#include "repose/surrogate/selection.hpp"

#include <gtest/gtest.h>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::smooth_function;
using test::uniform_points;

const std::vector<Input> kTwo(2);

/// A steep plane and a smooth ripple.
Vector sloped(const Matrix& x) {
  return 30.0 * x.col(0) - 20.0 * x.col(1) + (8.0 * x.col(0).array()).sin().matrix() * 0.3;
}

TEST(SelectModel, TakesTheBestOfAllByWhatWasLeftOut) {
  const Matrix x = uniform_points(25, 2, 3);
  const Selection s = select_model(x, sloped(x), kTwo, {.noise = Noise::none, .starts = 1});
  ASSERT_EQ(s.candidates.size(), 40u);
  const Candidate& best = s.candidates.front();
  EXPECT_EQ(s.model.kernel(), best.kernel);
  EXPECT_EQ(s.model.basis(), best.basis);
  EXPECT_EQ(s.model.leave_one_out().log_density, best.log_density);
  for (std::size_t i = 1; i < s.candidates.size(); ++i)
    if (s.candidates[i].failure.empty()) {
      EXPECT_LE(s.candidates[i].log_density, s.candidates[i - 1].log_density);
    }
  EXPECT_NE(best.kernel.correlation, Correlation::exponential);  // of a smooth function
  EXPECT_GT(best.q2, 0.999);
}

TEST(SelectModel, JudgesByGroupsWhereGroupsAreGiven) {
  const Matrix x = uniform_points(24, 2, 3);
  std::vector<Eigen::Index> groups;
  for (Eigen::Index i = 0; i < 24; ++i) groups.push_back(x(i, 0) < 0.5 ? 0 : 1);
  const SelectionOptions by_group{.kernels = {{}, {Correlation::exponential}},
                                  .bases = {Basis::constant, Basis::linear},
                                  .groups = groups};
  const Selection s = select_model(x, sloped(x), kTwo, {.noise = Noise::none}, by_group);
  EXPECT_EQ(s.model.basis(), Basis::linear);  // half of the range is extrapolated
  EXPECT_EQ(s.candidates.front().log_density, s.model.leave_groups_out(groups).log_density);
}

TEST(SelectModel, GivesTheSameForAnyNumberOfThreads) {
  const Matrix x = uniform_points(20, 2, 4);
  const Vector y = at_rows(x, smooth_function);
  const SelectionOptions one{.bases = {Basis::constant}};
  SelectionOptions two = one;
  two.threads = 2;
  const Selection a = select_model(x, y, kTwo, {.starts = 1}, one);
  const Selection b = select_model(x, y, kTwo, {.starts = 1}, two);
  for (std::size_t i = 0; i < a.candidates.size(); ++i)
    EXPECT_EQ(a.candidates[i].log_density, b.candidates[i].log_density);
}

TEST(SelectModel, RanksWhatCannotBeFittedLastAndSaysWhy) {
  Matrix x = uniform_points(12, 2, 5);
  x.col(1).setConstant(0.5);  // no linear trend in it
  const Vector y = at_rows(x, smooth_function);
  const Selection s = select_model(x, y, kTwo, {.starts = 1}, {.kernels = {Kernel{}}});
  EXPECT_TRUE(s.candidates[0].failure.empty());
  EXPECT_NE(s.candidates.back().failure.find("depends on"), std::string::npos);
  EXPECT_THROW(select_model(x, y, kTwo, {}, {.bases = {Basis::linear}}), InputError);
  EXPECT_THROW(select_model(x, y, kTwo, {}, {.kernels = {}}), InputError);
  EXPECT_THROW(select_model(x, y, kTwo, {}, {.groups = {1, 2}}), InputError);
}

TEST(SelectModel, OfAConstantResponseIsThatConstant) {
  const Matrix x = uniform_points(12, 2, 5);
  const Selection s =
      select_model(x, Vector::Constant(12, 7.0), kTwo, {.starts = 1}, {.kernels = {Kernel{}}});
  EXPECT_EQ(s.model.basis(), Basis::constant);
  EXPECT_NEAR(s.model.predict(Vector{{0.1, 0.9}}).mean, 7.0, 1e-12);
}

}  // namespace
}  // namespace repose::surrogate
