// One regression tree against a tree found by trying everything, and by hand.
#include <gtest/gtest.h>

#include <limits>

#include "repose/base/error.hpp"
#include "repose/surrogate/tree.hpp"
#include "tree_data.hpp"

namespace repose::surrogate {
namespace {

using test::ExhaustiveTree;
using test::mixed_sample;

/// Rounding of a mean of n numbers of size `scale`.
double rounding(const TrainingSet& data) {
  return 4.0 * static_cast<double>(data.rows()) * std::numeric_limits<double>::epsilon() *
         data.y.cwiseAbs().maxCoeff();
}

void expect_exhaustive(const TrainingSet& data, const TreeOptions& options) {
  const auto tree = RegressionTree::fit(data, options);
  const ExhaustiveTree twin(data, options);
  EXPECT_EQ(tree.nodes().size(), twin.nodes());
  const Matrix probe = mixed_sample(300, 77).x;
  EXPECT_LE((tree.predict(probe) - twin.predict(probe)).cwiseAbs().maxCoeff(), rounding(data));
}

TEST(RegressionTree, IsTheOneThatTryingEveryDivisionFinds) {
  for (const std::uint64_t seed : {1, 2, 3, 4})
    for (const Eigen::Index leaf : {1, 3, 7})
      expect_exhaustive(mixed_sample(60, seed), {.minimum_leaf = leaf});
}

TEST(RegressionTree, WithWeightsIsTheOneThatTryingEveryDivisionFinds) {
  TrainingSet data = mixed_sample(60, 5);
  data.weights = test::uniform_points(60, 1, 6).col(0).array() + 0.1;
  expect_exhaustive(data, {.minimum_leaf = 2});
}

TEST(RegressionTree, KeepsItsLimitsAsLayersDo) {
  const TrainingSet data = mixed_sample(80, 9);
  for (const Eigen::Index splits : {1, 2, 4, 5, 6, 11, 20}) {
    expect_exhaustive(data, {.minimum_leaf = 2, .maximum_splits = splits});
    const auto tree = RegressionTree::fit(data, {.minimum_leaf = 2, .maximum_splits = splits});
    EXPECT_EQ(tree.leaves(), splits + 1);
  }
  for (const Eigen::Index depth : {1, 2, 3}) {
    expect_exhaustive(data, {.minimum_leaf = 1, .maximum_depth = depth});
    EXPECT_EQ(RegressionTree::fit(data, {.minimum_leaf = 1, .maximum_depth = depth}).depth(),
              depth);
  }
}

// steps at 0.35 and 0.65; the first division is where it explains most
TEST(RegressionTree, FindsTheStepsOfAStaircase) {
  TrainingSet data{.x = Matrix(10, 1), .y = Vector(10), .inputs = {{}}};
  for (Eigen::Index i = 0; i < 10; ++i) {
    data.x(i, 0) = 0.1 * static_cast<double>(i);
    data.y[i] = i < 4 ? 1.0 : i < 7 ? 2.0 : 5.0;
  }
  const auto tree = RegressionTree::fit(data, {.minimum_leaf = 1});
  const auto nodes = tree.nodes();
  ASSERT_EQ(nodes.size(), 5u);
  EXPECT_EQ(nodes[0].input, 0);
  EXPECT_DOUBLE_EQ(nodes[0].threshold, 0.65);
  EXPECT_DOUBLE_EQ(nodes[static_cast<std::size_t>(nodes[0].left)].threshold, 0.35);
  EXPECT_DOUBLE_EQ(nodes[0].mean, 2.5);
  EXPECT_EQ(tree.predict(Matrix{{-10.0}, {0.349}, {0.351}, {0.66}, {10.0}}),
            (Vector{{1.0, 1.0, 2.0, 5.0, 5.0}}));
}

TEST(RegressionTree, DividesACategoryByTheMeansOfItsLevels) {
  TrainingSet data{.x = Matrix{{0}, {1}, {2}, {3}, {0}, {1}, {2}, {3}},
                   .y = Vector{{5.0, 1.0, 5.5, 1.5, 5.0, 1.0, 5.5, 1.5}},
                   .inputs = {{.levels = {"a", "b", "c", "d", "never seen"}}}};
  const auto tree = RegressionTree::fit(data, {.minimum_leaf = 1, .maximum_splits = 1});
  const auto root = tree.nodes().front();
  EXPECT_EQ(root.left_levels, (std::vector<bool>{false, true, false, true, true}));
  EXPECT_EQ(tree.predict(Matrix{{0.0}, {3.0}, {4.0}}), (Vector{{5.25, 1.25, 1.25}}));
}

TEST(RegressionTree, WithoutLimitsReproducesItsRows) {
  const TrainingSet data = mixed_sample(200, 3);
  const auto tree = RegressionTree::fit(data, {.minimum_leaf = 1});
  EXPECT_LE((tree.predict(data.x) - data.y).cwiseAbs().maxCoeff(), rounding(data));
}

TEST(RegressionTree, CountsAWeightOfTwoAsARepeat) {
  const TrainingSet once = mixed_sample(50, 8);
  TrainingSet weighted = once;
  weighted.weights = Vector::Ones(50);
  weighted.weights.head(10).setConstant(2.0);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < 60; ++i) rows.push_back(i % 50);
  const TrainingSet repeated = selected_rows(once, rows);
  const Matrix probe = mixed_sample(200, 10).x;
  const TreeOptions options{.minimum_leaf = 1, .maximum_splits = 12};
  EXPECT_LE((RegressionTree::fit(weighted, options).predict(probe) -
             RegressionTree::fit(repeated, options).predict(probe))
                .cwiseAbs()
                .maxCoeff(),
            rounding(once));
}

TEST(RegressionTree, DoesNotDependOnUnits) {
  TrainingSet data = mixed_sample(100, 4);
  const auto tree = RegressionTree::fit(data);
  const Matrix probe = mixed_sample(100, 5).x;
  TrainingSet other = data;
  other.y = data.y.array() * std::ldexp(1.0, 20);
  EXPECT_EQ(RegressionTree::fit(other).predict(probe), tree.predict(probe) * std::ldexp(1.0, 20));
  other.y = data.y.array() + 1e6;
  const Vector shift = RegressionTree::fit(other).predict(probe) - tree.predict(probe);
  EXPECT_LE((shift.array() - 1e6).abs().maxCoeff(), rounding(other));
}

// The light rows are lost in the total, so that nothing seems to be left for their side; what gains
// most is to part the heavy ones, by a number of few or many values and by a category.
TEST(RegressionTree, DividesHeavyRowsWhereOthersWeighNothing) {
  for (const Eigen::Index light : {2, 30})
    for (const bool is_category : {false, true}) {
      TrainingSet data{.x = Matrix(light + 2, 1),
                       .y = Vector::Constant(light + 2, 5.0),
                       .inputs = std::vector<Input>(1)};
      data.weights = Vector::Ones(light + 2);
      data.weights.head(2).setConstant(1e19);
      data.y.head(2) << 0.0, 1.0;
      for (Eigen::Index i = 0; i < light + 2; ++i) {
        data.x(i, 0) = static_cast<double>(i);
        if (is_category) data.inputs[0].levels.push_back(std::to_string(i));
      }
      if (!is_category) data.inputs[0].upper = static_cast<double>(light + 2);
      const auto tree = RegressionTree::fit(data, {.minimum_leaf = 1, .maximum_splits = 1});
      EXPECT_EQ(tree.predict(data.x.topRows(2)), (Vector{{0.0, 1.0}}));
    }
}

TEST(RegressionTree, OfEqualDivisionsTakesTheFirstInput) {
  TrainingSet data = mixed_sample(60, 2);
  data.x.col(3) = data.x.col(1);
  data.x.col(0) = data.x.col(1);
  data.x.col(2).setOnes();
  data.inputs = {{.upper = 3.0}, {.upper = 3.0}, {}, {.upper = 3.0}};
  for (const TreeNode& node : RegressionTree::fit(data, {.minimum_leaf = 1}).nodes())
    EXPECT_LE(node.input, 0);
}

TEST(RegressionTree, DrawsPredictorsBySeedAndGoesOnWhereTheseCannotDivide) {
  TrainingSet data = mixed_sample(80, 6);
  const TreeOptions one{.minimum_leaf = 1, .predictors = 1};
  const Matrix probe = mixed_sample(100, 5).x;
  EXPECT_EQ(RegressionTree::fit(data, one, 3).predict(probe),
            RegressionTree::fit(data, one, 3).predict(probe));
  EXPECT_NE(RegressionTree::fit(data, one, 3).predict(probe),
            RegressionTree::fit(data, one, 4).predict(probe));
  // whatever is drawn first, all rows end up in leaves of their own
  EXPECT_LE((RegressionTree::fit(data, one, 3).predict(data.x) - data.y).cwiseAbs().maxCoeff(),
            rounding(data));
  EXPECT_EQ(RegressionTree::fit(data, {.predictors = 4}).predict(probe),
            RegressionTree::fit(data).predict(probe));
}

TEST(RegressionTree, IsOneLeafWhereNothingCanBeDivided) {
  TrainingSet one{.x = Matrix{{1.0, 2.0}}, .y = Vector{{3.0}}, .inputs = {{}, {}}};
  EXPECT_EQ(RegressionTree::fit(one, {.minimum_leaf = 1}).predict(Matrix{{5.0, 5.0}}),
            Vector{{3.0}});
  TrainingSet data = mixed_sample(40, 1);
  data.y.setConstant(0.1);
  EXPECT_EQ(RegressionTree::fit(data, {.minimum_leaf = 1}).leaves(), 1);
  data = mixed_sample(40, 1);
  for (Eigen::Index i = 1; i < 40; ++i) data.x.row(i) = data.x.row(0);
  EXPECT_EQ(RegressionTree::fit(data, {.minimum_leaf = 1}).leaves(), 1);
  EXPECT_NEAR(RegressionTree::fit(data).predict(data.x)[7], data.y.mean(), rounding(data));
}

TEST(RegressionTree, DividesNeighboringNumbersWhereTheirMiddleRounds) {
  const double a = 1.0;
  const double b = std::nextafter(a, 2.0);
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (const auto& [below, above] :
       {std::pair(a, b), std::pair(0.0, tiny), std::pair(-1.7e308, 1.7e308)}) {
    const TrainingSet data{.x = Matrix{{below}, {above}},
                           .y = Vector{{1.0, 2.0}},
                           .inputs = {{.lower = -1.0, .upper = 1.0}}};
    EXPECT_EQ(RegressionTree::fit(data, {.minimum_leaf = 1}).predict(data.x), data.y);
  }
}

TEST(RegressionTree, SaysWhatOptionIsWrong) {
  const TrainingSet data = mixed_sample(20, 1);
  EXPECT_THROW(RegressionTree::fit(data, {.minimum_leaf = 0}), InputError);
  EXPECT_THROW(RegressionTree::fit(data, {.maximum_splits = 0}), InputError);
  EXPECT_THROW(RegressionTree::fit(data, {.maximum_depth = -1}), InputError);
  EXPECT_THROW(RegressionTree::fit(data, {.predictors = 5}), InputError);
  TrainingSet bad = data;
  bad.x(3, 3) = 5.0;
  EXPECT_THROW(RegressionTree::fit(bad), InputError);
  const auto tree = RegressionTree::fit(data);
  EXPECT_THROW(tree.predict(Matrix::Constant(1, 4, 7.0)), InputError);
  EXPECT_THROW(tree.predict(Matrix::Zero(2, 3)), InputError);
  EXPECT_EQ(tree.predict(Matrix(0, 4)).size(), 0);
}

TEST(RegressionTree, DescribesItself) {
  const auto tree =
      RegressionTree::fit(mixed_sample(80, 9), {.minimum_leaf = 2, .maximum_splits = 6});
  EXPECT_EQ(tree.describe(), "regression tree of 7 leaves, minimum leaf 2, at most 6 splits");
}

}  // namespace
}  // namespace repose::surrogate
