// Bags of trees against what their definition says, tree by tree.
#include "repose/surrogate/bagged_trees.hpp"

#include <gtest/gtest.h>

#include <map>

#include "repose/base/error.hpp"
#include "tree_data.hpp"

namespace repose::surrogate {
namespace {

using test::mixed_sample;

/// The bag of a tree, as points drawn from the tree's own stream.
std::vector<Eigen::Index> bag_of(std::uint64_t seed, std::uint64_t tree, Eigen::Index points) {
  RandomStream random(seed, tree);
  std::vector<Eigen::Index> bag;
  for (Eigen::Index i = 0; i < points; ++i)
    bag.push_back(static_cast<Eigen::Index>(random.below(static_cast<std::uint64_t>(points))));
  return bag;
}

bool holds(const std::vector<Eigen::Index>& bag, Eigen::Index point) {
  return std::find(bag.begin(), bag.end(), point) != bag.end();
}

/// With all predictors: nothing is drawn but the bags.
BaggedTreesOptions plain(Eigen::Index trees, Eigen::Index leaf = 3) {
  return {.trees = trees, .tree = {.minimum_leaf = leaf, .predictors = 4}, .seed = 7};
}

TEST(BaggedTrees, AreTheMeanOfTreesFittedToTheirBags) {
  const TrainingSet data = mixed_sample(60, 1);
  const auto bag = BaggedTrees::fit(data, plain(12));
  const Matrix probe = mixed_sample(50, 2).x;
  Vector mean = Vector::Zero(50);
  for (std::uint64_t t = 0; t < 12; ++t)
    mean += RegressionTree::fit(selected_rows(data, bag_of(7, t, 60)), {.minimum_leaf = 3})
                .predict(probe) /
            12.0;
  EXPECT_LE((bag.predict(probe) - mean).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(BaggedTrees, PredictEachRowOutOfBagByTheTreesWithoutIt) {
  const TrainingSet data = mixed_sample(60, 1);
  const auto bag = BaggedTrees::fit(data, plain(20));
  Vector sum = Vector::Zero(60);
  Vector number = Vector::Zero(60);
  for (std::uint64_t t = 0; t < 20; ++t) {
    const auto rows = bag_of(7, t, 60);
    const Vector predicted =
        RegressionTree::fit(selected_rows(data, rows), {.minimum_leaf = 3}).predict(data.x);
    for (Eigen::Index i = 0; i < 60; ++i)
      if (!holds(rows, i)) sum[i] += predicted[i], number[i] += 1.0;
  }
  ASSERT_GT(number.minCoeff(), 0.0);
  const Vector expected = sum.cwiseQuotient(number);
  const OutOfBag& out = bag.out_of_bag();
  EXPECT_LE((out.predicted - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(out.rows, 60);
  const double squares = (data.y - expected).squaredNorm();
  EXPECT_NEAR(out.rmse, std::sqrt(squares / 60.0), 1e-12);
  EXPECT_NEAR(out.q2, 1.0 - squares / (data.y.array() - data.y.mean()).square().sum(), 1e-12);
}

// a row is in a bag with probability 0.63: two trees have half of the rows in both or neither
TEST(BaggedTrees, SayWhichRowsAreInEveryBag) {
  const TrainingSet data = mixed_sample(60, 1);
  const OutOfBag out = BaggedTrees::fit(data, plain(2)).out_of_bag();
  Eigen::Index missing = 0;
  for (Eigen::Index i = 0; i < 60; ++i) {
    const bool in_all = holds(bag_of(7, 0, 60), i) && holds(bag_of(7, 1, 60), i);
    EXPECT_EQ(std::isnan(out.predicted[i]), in_all);
    missing += in_all ? 1 : 0;
  }
  EXPECT_EQ(out.rows, 60 - missing);
  EXPECT_TRUE(std::isfinite(out.rmse));
}

TEST(BaggedTrees, GiveTheSameBitsForAnyNumberOfThreads) {
  const TrainingSet data = mixed_sample(150, 4);
  const Matrix probe = mixed_sample(40, 2).x;
  BaggedTreesOptions options{.trees = 30, .seed = 5};
  const auto one = BaggedTrees::fit(data, options);
  for (const unsigned threads : {2u, 8u}) {
    options.threads = threads;
    const auto many = BaggedTrees::fit(data, options);
    EXPECT_EQ(many.predict(probe), one.predict(probe));
    EXPECT_EQ(many.out_of_bag().rmse, one.out_of_bag().rmse);
    EXPECT_EQ(many.predict_with_variances(probe).observation_variance,
              one.predict_with_variances(probe).observation_variance);
  }
  options.seed = 6;
  EXPECT_NE(BaggedTrees::fit(data, options).predict(probe), one.predict(probe));
}

// V_IJ-U of [Wager2014] from its definition, with the variance of a mean of B trees
TEST(BaggedTrees, HaveTheJackknifesVariance) {
  const TrainingSet data = mixed_sample(25, 1);
  constexpr Eigen::Index kTrees = 200;
  const auto bag = BaggedTrees::fit(data, plain(kTrees));
  const Matrix probe = mixed_sample(10, 2).x;
  Matrix t(kTrees, 10);
  Matrix n = Matrix::Zero(kTrees, 25);
  for (Eigen::Index b = 0; b < kTrees; ++b) {
    const auto rows = bag_of(7, static_cast<std::uint64_t>(b), 25);
    for (const Eigen::Index i : rows) n(b, i) += 1.0;
    t.row(b) = RegressionTree::fit(selected_rows(data, rows), {.minimum_leaf = 3}).predict(probe);
  }
  const Vector variance = bag.predict_with_variances(probe).function_variance;
  for (Eigen::Index p = 0; p < 10; ++p) {
    const Vector d = t.col(p).array() - t.col(p).mean();
    double jackknife = 0.0;
    for (Eigen::Index i = 0; i < 25; ++i)
      jackknife += std::pow((n.col(i).array() - n.col(i).mean()).matrix().dot(d) / kTrees, 2);
    const double corrected = jackknife - 25.0 / (kTrees * kTrees) * d.squaredNorm();
    const double of_mean = d.squaredNorm() / (kTrees * (kTrees - 1.0));
    EXPECT_NEAR(variance[p], std::max(corrected, 0.0) + of_mean, 1e-10 * d.squaredNorm());
  }
}

// [Lu2021] from its definition: errors of the rows that share leaves with x while out of bag
TEST(BaggedTrees, HaveTheVarianceOfErrorsNearby) {
  const TrainingSet data = mixed_sample(60, 1);
  const auto bag = BaggedTrees::fit(data, plain(30));
  const Matrix probe = mixed_sample(10, 2).x;
  Vector squares = Vector::Zero(10);
  Vector number = Vector::Zero(10);
  for (std::uint64_t t = 0; t < 30; ++t) {
    const auto rows = bag_of(7, t, 60);
    const auto tree = RegressionTree::fit(selected_rows(data, rows), {.minimum_leaf = 3});
    const Vector at_probe = tree.predict(probe);  // leaves have different means
    const Vector at_rows = tree.predict(data.x);
    for (Eigen::Index p = 0; p < 10; ++p)
      for (Eigen::Index i = 0; i < 60; ++i)
        if (!holds(rows, i) && std::abs(at_rows[i] - at_probe[p]) < 1e-13) {
          squares[p] += std::pow(data.y[i] - bag.out_of_bag().predicted[i], 2);
          number[p] += 1.0;
        }
  }
  ASSERT_GT(number.minCoeff(), 0.0);
  EXPECT_LE((bag.predict_with_variances(probe).observation_variance - squares.cwiseQuotient(number))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

// Errors out of bag are those of fewer trees, so a little too large; the mean over 8 data sets of a
// ratio of variances from 120 rows scatters by sqrt(2/120/8) = 5 %
TEST(BaggedTrees, ExpectErrorsAsLargeAsTheyAre) {
  double ratio = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto bag = BaggedTrees::fit(mixed_sample(120, seed), {.trees = 300});
    const TrainingSet fresh = mixed_sample(1000, 100 + seed);
    const Predictions p = bag.predict_with_variances(fresh.x);
    ratio += (fresh.y - p.mean).squaredNorm() / p.observation_variance.sum() / 8.0;
  }
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.1);
}

TEST(BaggedTrees, DrawReplicatesTogether) {
  TrainingSet data = mixed_sample(60, 1);
  for (Eigen::Index i = 0; i < 60; ++i) data.replicates.push_back(1000 - i / 3);
  const auto bag = BaggedTrees::fit(data, plain(2));
  EXPECT_EQ(bag.points(), 20);
  for (Eigen::Index i = 0; i < 60; ++i) {
    const bool in_all = holds(bag_of(7, 0, 20), i / 3) && holds(bag_of(7, 1, 20), i / 3);
    EXPECT_EQ(std::isnan(bag.out_of_bag().predicted[i]), in_all);
  }
}

// rows that repeat a point are drawn with it, so that the bags are the same
TEST(BaggedTrees, CountAWeightOfTwoAsARepeat) {
  const TrainingSet once = mixed_sample(50, 8);
  TrainingSet weighted = once;
  weighted.weights = Vector::Ones(50);
  weighted.weights.head(10).setConstant(2.0);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < 60; ++i) rows.push_back(i % 50);
  const BaggedTreesOptions options{
      .trees = 20, .tree = {.minimum_leaf = 1, .maximum_splits = 12}, .seed = 3};
  const Matrix probe = mixed_sample(100, 10).x;
  const auto a = BaggedTrees::fit(weighted, options);
  const auto b = BaggedTrees::fit(selected_rows(once, rows), options);
  EXPECT_NEAR(a.out_of_bag().rmse, b.out_of_bag().rmse, 1e-12);
  const Predictions p = a.predict_with_variances(probe);
  const Predictions q = b.predict_with_variances(probe);
  EXPECT_LE((p.mean - q.mean).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((p.observation_variance - q.observation_variance).cwiseAbs().maxCoeff(), 1e-12);
}

// heavy rows step with the first input, light ones with the second
TEST(BaggedTrees, FindUnimportantWhatMattersToLightRows) {
  TrainingSet data{
      .x = test::uniform_points(300, 3, 1), .y = Vector(300), .inputs = std::vector<Input>(3)};
  data.weights.resize(300);
  for (Eigen::Index i = 0; i < 300; ++i) {
    const bool heavy = data.x(i, 2) < 0.5;
    data.y[i] = data.x(i, heavy ? 0 : 1) < 0.5 ? 0.0 : 1.0;
    data.weights[i] = heavy ? 1.0 : 1e-6;
  }
  const auto importance = BaggedTrees::fit(data, {.trees = 50}).importance(data);
  EXPECT_NEAR(importance[0].increase, 0.5, 0.07);  // twice the variance of the heavy rows
  EXPECT_LT(importance[1].increase, 0.01);
}

// y depends on the first input alone; permuting it gives twice the variance of y
TEST(BaggedTrees, KnowWhichInputMatters) {
  TrainingSet data{
      .x = test::uniform_points(300, 3, 1), .y = Vector(300), .inputs = std::vector<Input>(3)};
  for (Eigen::Index i = 0; i < 300; ++i) data.y[i] = data.x(i, 0) < 0.5 ? 0.0 : 1.0;
  const auto bag = BaggedTrees::fit(data, {.trees = 50, .tree = {.predictors = 3}});
  const auto importance = bag.importance(data);
  ASSERT_EQ(importance.size(), 3u);
  // 2 x 0.25, and the spread of 50 permutations of 110 rows
  EXPECT_NEAR(importance[0].increase, 0.5, 0.05);
  EXPECT_GT(importance[0].standard_error, 0.0);
  EXPECT_LT(importance[0].standard_error, 0.02);
  EXPECT_EQ(importance[1].increase, 0.0);  // never used
  EXPECT_EQ(bag.importance(data)[0].increase, importance[0].increase);
  EXPECT_THROW(bag.importance(selected_rows(data, std::vector<Eigen::Index>{0, 1})), InputError);
}

TEST(PermutationImportance, IsTwiceTheVarianceOfAnAdditivePart) {
  struct Sum {
    std::vector<Input> all = std::vector<Input>(3);
    Vector predict(const Matrix& x) const { return 2.0 * x.col(0) + x.col(1); }
    const std::vector<Input>& inputs() const { return all; }
    std::string describe() const { return "sum"; }
  };
  TrainingSet data{.x = test::uniform_points(400, 3, 1), .y = {}, .inputs = std::vector<Input>(3)};
  data.y = Sum().predict(data.x);
  const auto importance = permutation_importance(Sum(), data, {.permutations = 50});
  const auto variance = [&](Eigen::Index k) {
    return (data.x.col(k).array() - data.x.col(k).mean()).square().mean();
  };
  // E (a - a')^2 over permutations is 2 n/(n-1) var; five standard errors
  EXPECT_NEAR(importance[0].increase, 8.0 * variance(0),
              5.0 * importance[0].standard_error + 0.004);
  EXPECT_NEAR(importance[1].increase, 2.0 * variance(1),
              5.0 * importance[1].standard_error + 0.001);
  EXPECT_EQ(importance[2].increase, 0.0);
  EXPECT_THROW(permutation_importance(Sum(), data, {.permutations = 1}), InputError);
}

TEST(BaggedTrees, PredictMoreThanAConstantFromFiftyRowsByDefault) {
  const TrainingSet data = mixed_sample(50, 3);
  const auto bag = BaggedTrees::fit(data);
  EXPECT_GT(bag.out_of_bag().q2, 0.2);
}

TEST(BaggedTrees, OfOneRowOrAConstantAreThat) {
  const TrainingSet one{.x = Matrix{{1.0}}, .y = Vector{{3.0}}, .inputs = {{}}};
  const auto bag = BaggedTrees::fit(one);
  const Predictions p = bag.predict_with_variances(Matrix{{4.0}});
  EXPECT_EQ(p.mean, Vector{{3.0}});
  EXPECT_EQ(p.observation_variance.size(), 0);
  EXPECT_EQ(bag.out_of_bag().rows, 0);
  EXPECT_TRUE(std::isnan(bag.out_of_bag().rmse));
  TrainingSet constant = mixed_sample(30, 1);
  constant.y.setConstant(2.0);
  const Predictions c = BaggedTrees::fit(constant).predict_with_variances(constant.x);
  EXPECT_EQ(c.mean, constant.y);
  EXPECT_EQ(c.observation_variance, Vector::Zero(30));
  EXPECT_EQ(c.function_variance, Vector::Zero(30));
}

TEST(BaggedTrees, RefuseNoTrees) {
  EXPECT_THROW(BaggedTrees::fit(mixed_sample(30, 1), {.trees = 0}), InputError);
  EXPECT_THROW(BaggedTrees::fit(mixed_sample(30, 1), {.tree = {.minimum_leaf = 0}}), InputError);
}

}  // namespace
}  // namespace repose::surrogate
