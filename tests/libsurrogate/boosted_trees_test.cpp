// Boosting against the recursion that defines it.
#include "repose/surrogate/boosted_trees.hpp"

#include <gtest/gtest.h>

#include "repose/base/error.hpp"
#include "tree_data.hpp"

namespace repose::surrogate {
namespace {

using test::mixed_sample;

// [Hadi2026, Eqs. 4.2-4.5] with single trees
TEST(BoostedTrees, FollowTheRecursionOfResiduals) {
  TrainingSet data = mixed_sample(80, 1);
  for (const bool weighted : {false, true}) {
    if (weighted) data.weights = Vector::LinSpaced(80, 0.5, 2.0);
    const BoostedTreesOptions options{
        .trees = 15, .learning_rate = 0.3, .tree = {.minimum_leaf = 2, .maximum_depth = 3}};
    const auto model = BoostedTrees::fit(data, options);
    const Matrix probe = mixed_sample(40, 2).x;
    const double mean = weighted ? data.weights.dot(data.y) / data.weights.sum() : data.y.mean();
    EXPECT_NEAR(model.constant(), mean, 1e-13);
    Vector f = Vector::Constant(80, mean);
    Vector at_probe = Vector::Constant(40, mean);
    for (int m = 0; m < 15; ++m) {
      TrainingSet residuals = data;
      residuals.y = data.y - f;
      const auto tree = RegressionTree::fit(residuals, options.tree);
      f += 0.3 * tree.predict(data.x);
      at_probe += 0.3 * tree.predict(probe);
    }
    EXPECT_LE((model.predict(probe) - at_probe).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_LE((model.predict(data.x) - f).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_EQ(model.trees(), 15);
  }
}

TEST(BoostedTrees, ReduceTheErrorOfTheirRowsWithEachTree) {
  const TrainingSet data = mixed_sample(80, 3);
  double before = std::numeric_limits<double>::infinity();
  for (const Eigen::Index trees : {1, 2, 5, 20, 100}) {
    const auto model = BoostedTrees::fit(data, {.trees = trees});
    const double squares = (model.predict(data.x) - data.y).squaredNorm();
    EXPECT_LT(squares, before);
    before = squares;
  }
}

TEST(BoostedTrees, EndWhereNothingIsLeftToExplain) {
  TrainingSet data = mixed_sample(40, 3);
  for (double& value : data.y) value = value > 0.5 ? 1.0 : 0.0;
  const auto model =
      BoostedTrees::fit(data, {.trees = 100, .learning_rate = 1.0, .tree = {.minimum_leaf = 1}});
  EXPECT_EQ(model.trees(), 1);
  EXPECT_LE((model.predict(data.x) - data.y).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(BoostedTrees, PredictMoreThanAConstantFromFiftyRowsByDefault) {
  const TrainingSet fresh = mixed_sample(500, 50);
  const auto model = BoostedTrees::fit(mixed_sample(50, 3));
  const double spread = (fresh.y.array() - fresh.y.mean()).square().sum();
  EXPECT_LT((model.predict(fresh.x) - fresh.y).squaredNorm(), 0.6 * spread);
}

// noise alone: the fewer trees the better; a clear function: many
TEST(BoostedTrees, StopEarlyWhereTreesLearnNoise) {
  TrainingSet noise = mixed_sample(100, 4);
  RandomStream random(9);
  for (double& value : noise.y) value = random.normal();
  for (const Stopping stopping : {Stopping::held_out, Stopping::k_fold}) {
    const TreeOptions small{.minimum_leaf = 1, .maximum_splits = 4};
    const BoostedTreesOptions options{
        .trees = 200, .learning_rate = 0.3, .tree = small, .stopping = stopping};
    const auto model = BoostedTrees::fit(noise, options);
    EXPECT_LT(model.trees(), 10) << to_string(stopping);
    const auto& curve = model.held_out_rmse();
    ASSERT_EQ(curve.size(), 201u);
    EXPECT_EQ(std::min_element(curve.begin(), curve.end()) - curve.begin(), model.trees());
  }
}

// what is kept are the first trees of a fit to all rows
TEST(BoostedTrees, StoppedEarlyAreThoseOfAShorterFit) {
  const TrainingSet data = mixed_sample(100, 4);
  BoostedTreesOptions options{.trees = 200,
                              .learning_rate = 0.3,
                              .tree = {.minimum_leaf = 1, .maximum_splits = 4},
                              .stopping = Stopping::k_fold};
  const auto stopped = BoostedTrees::fit(data, options);
  EXPECT_GT(stopped.trees(), 10);
  EXPECT_LT(stopped.trees(), 200);
  options.trees = stopped.trees();
  options.stopping = Stopping::none;
  EXPECT_EQ(BoostedTrees::fit(data, options).predict(data.x), stopped.predict(data.x));
}

// 4 points in 4 folds: each is predicted by the three others, a constant where leaves hold two rows
TEST(BoostedTrees, JudgeByRowsThatAreHeldOut) {
  const TrainingSet data{
      .x = Matrix{{0.0}, {0.3}, {0.6}, {0.9}}, .y = Vector{{1.0, 2.0, 4.0, 9.0}}, .inputs = {{}}};
  const auto model = BoostedTrees::fit(
      data, {.trees = 3, .tree = {.minimum_leaf = 2}, .stopping = Stopping::k_fold, .folds = 4});
  double squares = 0.0;
  for (Eigen::Index i = 0; i < 4; ++i)
    squares += std::pow(data.y[i] - (data.y.sum() - data.y[i]) / 3.0, 2);
  ASSERT_EQ(model.held_out_rmse().size(), 4u);
  for (const double rmse : model.held_out_rmse())
    EXPECT_NEAR(rmse, std::sqrt(squares / 4.0), 1e-14);
  EXPECT_EQ(model.trees(), 0);
  EXPECT_EQ(model.predict(Matrix{{0.1}}), Vector{{4.0}});
}

TEST(BoostedTrees, KeepReplicatesOnOneSide) {
  TrainingSet data = mixed_sample(160, 5);
  RandomStream random(3);
  for (Eigen::Index i = 0; i < 160; ++i) {
    data.x.row(i) = data.x.row(i / 2 * 2);
    data.replicates.push_back(i / 2);
    data.y[i] = i % 2 == 0 ? random.normal() : data.y[i - 1];
  }
  // a repeat in training lets many trees reproduce the noise of a row that is held out: four rows
  // of five then have no error
  const BoostedTreesOptions options{.trees = 100,
                                    .learning_rate = 0.5,
                                    .tree = {.minimum_leaf = 1},
                                    .stopping = Stopping::k_fold};
  const auto honest = BoostedTrees::fit(data, options);
  for (Eigen::Index i = 0; i < 160; ++i) data.replicates[static_cast<std::size_t>(i)] = i;
  const auto fooled = BoostedTrees::fit(data, options);
  EXPECT_GT(honest.held_out_rmse().back(), 1.5 * fooled.held_out_rmse().back());
}

TEST(BoostedTrees, GiveTheSameBitsForAnyNumberOfThreadsAndTheSameSeed) {
  const TrainingSet data = mixed_sample(100, 6);
  BoostedTreesOptions options{
      .trees = 40, .tree = {.predictors = 2}, .stopping = Stopping::k_fold, .seed = 3};
  const auto one = BoostedTrees::fit(data, options);
  options.threads = 4;
  const auto many = BoostedTrees::fit(data, options);
  EXPECT_EQ(many.predict(data.x), one.predict(data.x));
  EXPECT_EQ(many.held_out_rmse(), one.held_out_rmse());
  options.seed = 4;
  EXPECT_NE(BoostedTrees::fit(data, options).predict(data.x), one.predict(data.x));
}

TEST(BoostedTrees, OfOneRowOrAConstantAreThat) {
  const TrainingSet one{.x = Matrix{{1.0}}, .y = Vector{{3.0}}, .inputs = {{}}};
  EXPECT_EQ(BoostedTrees::fit(one).predict(Matrix{{4.0}}), Vector{{3.0}});
  EXPECT_EQ(BoostedTrees::fit(one).trees(), 0);
  TrainingSet constant = mixed_sample(30, 1);
  constant.y.setConstant(0.1);
  EXPECT_LE((BoostedTrees::fit(constant).predict(constant.x) - constant.y).cwiseAbs().maxCoeff(),
            1e-16);
}

TEST(BoostedTrees, SayWhatOptionIsWrong) {
  const TrainingSet data = mixed_sample(20, 1);
  EXPECT_THROW(BoostedTrees::fit(data, {.trees = 0}), InputError);
  EXPECT_THROW(BoostedTrees::fit(data, {.learning_rate = 0.0}), InputError);
  EXPECT_THROW(BoostedTrees::fit(data, {.learning_rate = 1.1}), InputError);
  EXPECT_THROW(BoostedTrees::fit(data, {.tree = {.predictors = 9}}), InputError);
  EXPECT_THROW(BoostedTrees::fit(data, {.stopping = Stopping::held_out, .folds = 21}), InputError);
  EXPECT_THROW(BoostedTrees::fit(data, {.stopping = Stopping::k_fold, .folds = 21}), InputError);
  EXPECT_THROW(BoostedTrees::fit(data, {.stopping = Stopping::k_fold, .folds = 1}), InputError);
}

}  // namespace
}  // namespace repose::surrogate
