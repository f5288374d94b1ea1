// Linear models against certified data, slow twins and their own equations.
#include "repose/surrogate/linear_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "regression_data.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/least_squares.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::surrogate {
namespace {

using test::smooth_data;

/// The model's slope along one input, which is exact for a linear one.
double slope(const LinearModel& model, Vector x, Eigen::Index k, double step) {
  Matrix two(2, x.size());
  two.row(0) = x;
  x[k] += step;
  two.row(1) = x;
  const Vector y = model.predict(two);
  return (y[1] - y[0]) / step;
}

TEST(LinearModel, HasTheCertifiedCoefficientsOfLongley) {
  const auto columns = test::read_columns("doe/nist/Longley.csv");
  const std::vector<double> certified{1.506187227137329E+01,  -3.581917929259101E-02,
                                      -2.020229803816825E+00, -1.033226867173592E+00,
                                      -5.110410565358071E-02, 1.829151464613552E+03};
  TrainingSet data{.x = test::matrix_of(columns, {"x1", "x2", "x3", "x4", "x5", "x6"}),
                   .y = columns.at("y"),
                   .inputs = {}};
  data.inputs = linear_inputs(test::range_of(data.x));
  const LinearModel model = LinearModel::fit(data);
  const Vector range = data.x.colwise().maxCoeff() - data.x.colwise().minCoeff();
  for (Eigen::Index k = 0; k < 6; ++k) {
    // rounding of two predictions of 6e4, through a matrix of condition 1e2 once inputs are coded
    const double rounding = 1e4 * 2.2e-16 * 6e4 / range[k];
    EXPECT_NEAR(slope(model, data.x.row(0), k, range[k]), certified[static_cast<std::size_t>(k)],
                rounding);
  }
  EXPECT_NEAR(std::sqrt(model.error_variance()), 3.048540735619648E+02, 305.0 * 1e-10);
  EXPECT_EQ(model.report().residual_df, 9);
}

TEST(LinearModel, OfInteractionsRecoversAProductExactly) {
  TrainingSet data = smooth_data(40, 3);
  data.y = ((1.0 + 2.0 * data.x.col(0).array()) * (3.0 - data.x.col(2).array())).matrix();
  const LinearModel model = LinearModel::fit(data, {.terms = LinearTerms::interactions});
  const Matrix x = test::uniform_points(20, 3, 99);
  const Vector truth = ((1.0 + 2.0 * x.col(0).array()) * (3.0 - x.col(2).array())).matrix();
  EXPECT_LT((model.predict(x) - truth).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(model.term_names({"a", "b", "c"}),
            (std::vector<std::string>{"1", "a", "b", "c", "a*b", "a*c", "b*c"}));
}

TEST(LinearModel, HasTheVariancesOfOrdinaryLeastSquares) {
  const TrainingSet data = smooth_data(25, 3);
  const LinearModel model = LinearModel::fit(data);
  const auto design = [](const Matrix& x) {
    Matrix m(x.rows(), x.cols() + 1);
    m << Vector::Ones(x.rows()), x;
    return m;
  };
  const doe::LeastSquaresFit twin = doe::fit_least_squares(design(data.x), data.y);
  const Matrix x = test::uniform_points(10, 3, 99);
  const Predictions p = model.predict_with_variances(x);
  const Matrix rows = design(x);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const double variance = twin.sigma * twin.sigma *
                            rows.row(i).dot(twin.unscaled_covariance * rows.row(i).transpose());
    EXPECT_NEAR(p.mean[i], rows.row(i).dot(twin.coefficients), 1e-12);
    EXPECT_NEAR(p.function_variance[i], variance, 1e-10 * variance);
    EXPECT_NEAR(p.observation_variance[i], variance + twin.sigma * twin.sigma, 1e-10 * variance);
  }
}

TEST(LinearModel, WithMoreTermsThanRowsHasTheSmallestCoefficients) {
  const TrainingSet data = smooth_data(12, 5);  // 16 coefficients
  const LinearModel model = LinearModel::fit(data, {.terms = LinearTerms::interactions});
  EXPECT_EQ(model.report().coefficients, 16);
  EXPECT_EQ(model.report().rank, 12);
  EXPECT_LT((model.predict(data.x) - data.y).cwiseAbs().maxCoeff(), 1e-11);
  const Matrix coded = 2.0 * data.x.array() - 1.0;
  std::vector<doe::Term> terms;
  for (int i = 0; i < 5; ++i) terms.push_back(doe::main_effect(i));
  for (int i = 0; i < 5; ++i)
    for (int j = i + 1; j < 5; ++j) terms.push_back(doe::interaction(i, j));
  const Matrix design = doe::model_matrix(coded, terms);
  const Vector twin =
      Eigen::JacobiSVD<Matrix>(design, Eigen::ComputeThinU | Eigen::ComputeThinV).solve(data.y);
  EXPECT_LT((model.coefficients() - twin).norm(), 1e-10 * twin.norm());
  EXPECT_TRUE(std::isnan(model.error_variance()));
  EXPECT_TRUE(model.predict_with_variances(data.x).observation_variance.array().isNaN().all());
}

TEST(LinearModel, DoesNotKnowWhatItsRowsDoNotDetermine) {
  TrainingSet data = smooth_data(20, 2);
  data.x.col(1) = data.x.col(0);  // the two are never told apart
  const LinearModel model = LinearModel::fit(data);
  EXPECT_EQ(model.report().rank, 2);
  const Predictions p = model.predict_with_variances(Matrix{{0.3, 0.3}, {0.3, 0.9}});
  EXPECT_LT(p.function_variance[0], 1.0);
  EXPECT_EQ(p.function_variance[1], std::numeric_limits<double>::infinity());
}

TEST(LinearModel, TakesALevelThatNoRowHasForTheFirst) {
  TrainingSet data = smooth_data(30, 2);
  data.inputs[1] = {.levels = {"a", "b", "c"}};
  for (Eigen::Index i = 0; i < 30; ++i) data.x(i, 1) = static_cast<double>(i % 2);
  const LinearModel model = LinearModel::fit(data);
  const Predictions p = model.predict_with_variances(Matrix{{0.3, 0.0}, {0.3, 1.0}, {0.3, 2.0}});
  EXPECT_EQ(p.mean[2], p.mean[0]);
  EXPECT_NE(p.mean[1], p.mean[0]);
  EXPECT_LT(p.function_variance[0], 1.0);
  EXPECT_EQ(p.function_variance[2], std::numeric_limits<double>::infinity());
  EXPECT_EQ(model.term_names({"x", "kind"}),
            (std::vector<std::string>{"1", "x", "kind=b", "kind=c"}));
}

TEST(LinearModel, CountsAWeightAsRepeats) {
  TrainingSet weighted = smooth_data(15, 2);
  TrainingSet repeated = weighted;
  weighted.weights = Vector::Ones(15);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < 15; ++i) {
    weighted.weights[i] = static_cast<double>(1 + i % 3);
    for (Eigen::Index r = 0; r <= i % 3; ++r) rows.push_back(i);
  }
  repeated = selected_rows(repeated, rows);
  const Matrix x = test::uniform_points(10, 2, 99);
  const Predictions a = LinearModel::fit(weighted).predict_with_variances(x);
  const Predictions b = LinearModel::fit(repeated).predict_with_variances(x);
  EXPECT_LT((a.mean - b.mean).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT((a.observation_variance - b.observation_variance).cwiseAbs().maxCoeff(), 1e-13);
}

/// Bisquare weights as the equations say, of the residuals of a finished fit.
Vector bisquare_weights(const Matrix& design, const Vector& residual) {
  const Matrix hat = design * (design.transpose() * design).inverse() * design.transpose();
  Vector adjusted(residual.size());
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    adjusted[i] = residual[i] / std::sqrt(1.0 - hat(i, i));
  std::vector<double> sizes;
  for (const double r : adjusted) sizes.push_back(std::abs(r));
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(sizes.begin(), sizes.begin() + design.cols() - 1);
  const std::size_t n = sizes.size();
  const double median = 0.5 * (sizes[(n - 1) / 2] + sizes[n / 2]);
  const Vector u = adjusted / (4.685 * median / 0.6744897501960817);
  return u.unaryExpr([](double v) { return std::abs(v) < 1.0 ? std::pow(1.0 - v * v, 2) : 0.0; });
}

TEST(RobustLinearModel, SolvesItsOwnWeightedEquations) {
  TrainingSet data = smooth_data(50, 3, 0.2);
  for (Eigen::Index i = 0; i < 5; ++i) data.y[7 * i] += 10.0;
  const LinearModel model = LinearModel::fit(data, {.method = LinearMethod::robust});
  EXPECT_TRUE(model.report().converged);
  Matrix design(50, 4);
  design << Vector::Ones(50), data.x;
  const Vector residual = data.y - model.predict(data.x);
  const Vector weights = bisquare_weights(design, residual);
  const Vector equations = design.transpose() * weights.cwiseProduct(residual);
  EXPECT_LT(equations.cwiseAbs().maxCoeff(), 1e-5);  // coefficients settle within 1e-8
  for (Eigen::Index i = 0; i < 5; ++i) EXPECT_EQ(weights[7 * i], 0.0);
}

TEST(RobustLinearModel, DoesNotFeelHowFarAnOutlierIs) {
  TrainingSet data = smooth_data(50, 3, 0.2);
  for (Eigen::Index i = 0; i < 5; ++i) data.y[7 * i] += 10.0;
  const LinearModel near = LinearModel::fit(data, {.method = LinearMethod::robust});
  for (Eigen::Index i = 0; i < 5; ++i) data.y[7 * i] += 1e4;
  const LinearModel far = LinearModel::fit(data, {.method = LinearMethod::robust});
  EXPECT_LT((near.predict(data.x) - far.predict(data.x)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT(near.error_variance(), 1.0);
}

TEST(RobustLinearModel, IsAlmostLeastSquaresWithNormalErrors) {
  // 95 % efficient: variances of the coefficients are 1/0.95 of those of least squares
  TrainingSet data = smooth_data(2000, 2, 0.0);
  RandomStream random(3);
  for (Eigen::Index i = 0; i < data.rows(); ++i) data.y[i] = data.x(i, 0) + random.normal();
  const Matrix x = test::uniform_points(5, 2, 9);
  const Predictions plain = LinearModel::fit(data).predict_with_variances(x);
  const Predictions robust =
      LinearModel::fit(data, {.method = LinearMethod::robust}).predict_with_variances(x);
  for (Eigen::Index i = 0; i < 5; ++i) {
    // of 2000 rows the ratio of estimated variances is known to about 3 sqrt(2/2000)
    EXPECT_NEAR(robust.function_variance[i] / plain.function_variance[i], 1.0 / 0.95, 0.1);
    EXPECT_NEAR(robust.observation_variance[i] / plain.observation_variance[i], 1.0, 0.15);
  }
}

TEST(RobustLinearModel, FitsALineThatMostRowsObeyExactly) {
  TrainingSet data = smooth_data(20, 1);
  data.y = (2.0 + 3.0 * data.x.col(0).array()).matrix();
  data.y[4] = 50.0;
  const LinearModel model = LinearModel::fit(data, {.method = LinearMethod::robust});
  EXPECT_NEAR(model.predict(Matrix{{0.5}})[0], 3.5, 1e-9);
}

TEST(RobustLinearModel, KeepsALevelWhoseRowsContradictEachOther) {
  TrainingSet data{.x = Matrix::Zero(42, 1), .y = Vector(42), .inputs = {{.levels = {"a", "b"}}}};
  RandomStream random(7);
  for (double& value : data.y) value = random.normal();
  data.x(40, 0) = data.x(41, 0) = 1.0;
  data.y[40] = 0.0;
  data.y[41] = 100.0;
  const LinearModel model = LinearModel::fit(data, {.method = LinearMethod::robust});
  EXPECT_NEAR(model.predict(Matrix{{1.0}})[0], 50.0, 1e-10);
  EXPECT_EQ(model.report().rank, 2);
  EXPECT_FALSE(model.report().converged);
}

TEST(StepwiseLinearModel, KeepsTheTermsThatMadeTheData) {
  TrainingSet data = smooth_data(60, 6);
  const Matrix c = 2.0 * data.x.array() - 1.0;
  RandomStream random(8);
  for (Eigen::Index i = 0; i < 60; ++i)
    data.y[i] = 1.0 + 2.0 * c(i, 1) + 3.0 * c(i, 2) * c(i, 4) + 0.05 * random.normal();
  const LinearModel model = LinearModel::fit(data, {.terms = LinearTerms::interactions,
                                                    .method = LinearMethod::stepwise,
                                                    .p_enter = 1e-4,
                                                    .p_leave = 1e-3});
  const auto names = model.term_names({"a", "b", "c", "d", "e", "f"});
  EXPECT_EQ(names, (std::vector<std::string>{"1", "b", "c", "e", "c*e"}));
  EXPECT_NEAR(std::sqrt(model.error_variance()), 0.05, 3.0 * 0.05 / std::sqrt(2.0 * 55.0));
}

TEST(StepwiseLinearModel, OfAConstantIsThatConstant) {
  TrainingSet data = smooth_data(10, 2);
  data.y.setConstant(4.0);
  const LinearModel model = LinearModel::fit(data, {.method = LinearMethod::stepwise});
  EXPECT_NEAR(model.predict(Matrix{{0.1, 0.2}})[0], 4.0, 1e-14);
}

TEST(LinearModel, OfOneRowIsThatRow) {
  TrainingSet data = smooth_data(1, 2);
  for (const auto method :
       {LinearMethod::least_squares, LinearMethod::robust, LinearMethod::stepwise}) {
    const LinearModel model = LinearModel::fit(data, {.method = method});
    EXPECT_NEAR(model.predict(data.x)[0], data.y[0], 1e-14);
  }
}

TEST(LinearModel, RefusesWhatItCannotFitWithASentence) {
  TrainingSet data = smooth_data(10, 2);
  EXPECT_THROW(LinearModel::fit(data, {.bisquare_constant = 0.0}), InputError);
  TrainingSet weighted = data;
  weighted.weights = Vector::Ones(10);
  EXPECT_THROW(LinearModel::fit(weighted, {.method = LinearMethod::robust}), InputError);
  data.y[3] = std::nan("");
  EXPECT_THROW(LinearModel::fit(data), InputError);
}

}  // namespace
}  // namespace repose::surrogate
