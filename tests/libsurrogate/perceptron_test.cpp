// Perceptrons: their gradient, what they can represent, and what their options promise.
#include <gtest/gtest.h>

#include <cmath>

#include "perceptron_state.hpp"
#include "regression_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::smooth_data;

double rmse(const Vector& a, const Vector& b) {
  return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.size()));
}

TEST(Network, GivesWhatItsLayersSay) {
  const Network network(2, {2});
  ASSERT_EQ(network.parameters(), 9);
  // W1 by columns, b1, W2, b2
  const Vector p{{1.0, -1.0, 2.0, 0.5, 0.1, -3.0, 4.0, 5.0, 0.25}};
  const Vector y = network.output(Matrix{{1.0, 2.0}, {3.0, 1.0}}, p);
  EXPECT_DOUBLE_EQ(y[0], 0.25);  // max(0, 1-2+0.1) = 0, max(0, 2+1-3) = 0
  EXPECT_DOUBLE_EQ(y[1], 4.0 * 2.1 + 5.0 * 3.5 + 0.25);
}

TEST(Network, HasTheGradientOfItsLoss) {
  const TrainingSet data = smooth_data(15, 3);
  Vector weights(15);
  for (Eigen::Index i = 0; i < 15; ++i) weights[i] = 1.0 + 0.1 * static_cast<double>(i);
  for (const std::vector<int>& hidden : {std::vector{4}, std::vector{4, 3}, std::vector{3, 3, 2}}) {
    const Network network(3, hidden);
    Vector at = network.start(3, 0);
    RandomStream random(5);
    for (double& value : at) value += 0.3 * random.normal();  // biases of 0 can sit on a kink
    Vector gradient(network.parameters());
    network.loss(data.x, data.y, weights, 0.1, at, &gradient);
    // the loss is quadratic between kinks: central differences err by rounding alone, eps/h
    const double h = 1e-5;
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      Vector up = at, down = at;
      up[k] += h;
      down[k] -= h;
      const double slope = (network.loss(data.x, data.y, weights, 0.1, up, nullptr) -
                            network.loss(data.x, data.y, weights, 0.1, down, nullptr)) /
                           (2.0 * h);
      EXPECT_NEAR(gradient[k], slope, 1e-8) << k;
    }
  }
}

TEST(Perceptron, LearnsAFunctionItCanRepresent) {
  TrainingSet data = smooth_data(60, 2);
  const auto ramp = [](const Matrix& x) {
    return Vector((x.col(0) - x.col(1)).cwiseMax(0.0) + 0.5 * x.col(1));
  };
  data.y = ramp(data.x);
  const Matrix x = test::uniform_points(200, 2, 5);
  const Perceptron model = Perceptron::fit(data, 1, {.layers = {10}, .networks = 1});
  EXPECT_LT(rmse(model.predict(x), ramp(x)), 0.02);
  EXPECT_LT(model.training()[0].loss, 1e-4);
}

TEST(Perceptron, BeatsTheMeanWithEveryDepth) {
  const TrainingSet data = smooth_data(100, 3, 0.02);
  const Matrix x = test::uniform_points(200, 3, 5);
  const Vector truth = test::at_rows(x, test::smooth_function);
  const double spread = rmse(truth, Vector::Constant(200, truth.mean()));
  for (const std::vector<int>& layers :
       {std::vector{10}, std::vector{10, 10}, std::vector{10, 10, 10}})
    EXPECT_LT(rmse(Perceptron::fit(data, 1, {.layers = layers, .penalty = 1e-3}).predict(x), truth),
              0.3 * spread);
}

TEST(Perceptron, UnderALargePenaltyIsTheMean) {
  const TrainingSet data = smooth_data(30, 2);
  const Vector y = Perceptron::fit(data, 1, {.penalty = 1e3}).predict(data.x);
  EXPECT_LT((y.array() - data.y.mean()).abs().maxCoeff(), 1e-3);
}

TEST(Perceptron, IsTheMeanOfItsNetworks) {
  const TrainingSet data = smooth_data(30, 2);
  const Perceptron model = Perceptron::fit(data, 1, {.networks = 3});
  ASSERT_EQ(model.training().size(), 3u);
  const auto& all = PerceptronAccess::state(model);
  Vector mean = Vector::Zero(30);
  for (std::size_t i = 0; i < 3; ++i) {
    PerceptronAccess::State one = all;
    one.parameters = {all.parameters[i]};
    mean += PerceptronAccess::make(one).predict(data.x) / 3.0;
  }
  EXPECT_NE(all.parameters[0], all.parameters[1]);
  EXPECT_LT((model.predict(data.x) - mean).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Perceptron, GivesTheSameBitsForTheSameSeed) {
  const TrainingSet data = smooth_data(30, 2);
  const Matrix x = test::uniform_points(10, 2, 5);
  EXPECT_EQ(Perceptron::fit(data, 4).predict(x), Perceptron::fit(data, 4).predict(x));
  EXPECT_NE(Perceptron::fit(data, 4).predict(x), Perceptron::fit(data, 5).predict(x));
}

TEST(Perceptron, CountsAWeightAsRepeats) {
  TrainingSet weighted = smooth_data(12, 2);
  weighted.weights = Vector::Ones(12);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < 12; ++i) {
    weighted.weights[i] = static_cast<double>(1 + i % 3);
    for (Eigen::Index r = 0; r <= i % 3; ++r) rows.push_back(i);
  }
  TrainingSet repeated = weighted;
  repeated.weights = {};
  repeated = selected_rows(repeated, rows);
  // the same loss: the same first steps up to rounding, which later ones magnify
  const PerceptronOptions options{
      .layers = {3}, .penalty = 0.1, .networks = 1, .standardisation = Standardisation::none};
  const Vector a = Perceptron::fit(weighted, 1, options).predict(weighted.x);
  const Vector b = Perceptron::fit(repeated, 1, options).predict(weighted.x);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(Perceptron, DoesNotFeelTheSizeOfAllWeights) {
  TrainingSet data = smooth_data(16, 2);
  const PerceptronOptions options{.layers = {3}, .penalty = 0.1, .networks = 1};
  data.weights = Vector::Ones(16);
  const Vector ones = Perceptron::fit(data, 1, options).predict(data.x);
  data.weights.setConstant(1.0 / 16.0);  // a power of 2: the same bits
  EXPECT_EQ(Perceptron::fit(data, 1, options).predict(data.x), ones);
  data.weights = {};
  // sums in another order
  EXPECT_LT((Perceptron::fit(data, 1, options).predict(data.x) - ones).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_GT(ones.maxCoeff() - ones.minCoeff(), 0.1);
}

TEST(Perceptron, OfAConstantIsThatConstant) {
  TrainingSet data = smooth_data(10, 2);
  data.y.setConstant(0.1);
  EXPECT_EQ(Perceptron::fit(data, 1).predict(test::uniform_points(3, 2, 5)),
            Vector::Constant(3, 0.1));
}

TEST(Perceptron, RefusesOptionsOutOfRangeWithASentence) {
  const TrainingSet data = smooth_data(10, 2);
  for (const PerceptronOptions& options :
       {PerceptronOptions{.layers = {}}, PerceptronOptions{.layers = {1, 1, 1, 1}},
        PerceptronOptions{.layers = {0}}, PerceptronOptions{.penalty = -1.0},
        PerceptronOptions{.networks = 0}, PerceptronOptions{.max_evaluations = 0}})
    EXPECT_THROW(Perceptron::fit(data, 1, options), InputError);
}

}  // namespace
}  // namespace repose::surrogate
