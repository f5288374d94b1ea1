// Asking and telling, with a surrogate small enough to see through.
#include "repose/opt/bayesian_optimizer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "functions.hpp"
#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

/// Simple kriging of values less their mean, squared exponential of length `length` of the ranges.
class Kriging {
 public:
  Kriging(Matrix x, Vector y, Vector range) : x_(std::move(x)), y_(std::move(y)), range_(range) {
    shift_ = y_.mean();
    scale_ = std::sqrt((y_.array() - shift_).square().mean()) + 1e-12;
    Matrix k = kernel(x_, x_);
    k.diagonal().array() += 1e-8;
    llt_.compute(k);
    alpha_ = llt_.solve((y_.array() - shift_).matrix() / scale_);
  }
  Gaussian predict(const Vector& x) const {
    const Vector k = kernel(x_, x.transpose()).col(0);
    return {shift_ + scale_ * k.dot(alpha_),
            scale_ * scale_ * std::max(0.0, 1.0 - k.dot(llt_.solve(k)))};
  }
  std::vector<Gaussian> predict_rows(const Matrix& rows) const {
    std::vector<Gaussian> all;
    for (const auto& row : rows.rowwise()) all.push_back(predict(row));
    return all;
  }
  Kriging condition_on(const Vector& x, double y) const {
    Matrix more(x_.rows() + 1, x.size());
    more << x_, x.transpose();
    Vector values(y_.size() + 1);
    values << y_, y;
    return {more, values, range_};
  }

 private:
  Matrix kernel(const Matrix& a, const Matrix& b) const {
    Matrix k(a.rows(), b.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      for (Eigen::Index j = 0; j < b.rows(); ++j)
        k(i, j) = std::exp(
            -0.5 * (a.row(i) - b.row(j)).transpose().cwiseQuotient(range_).squaredNorm() / 0.04);
    return k;
  }
  Matrix x_;
  Vector y_;
  Vector range_;
  double shift_ = 0.0;
  double scale_ = 1.0;
  Eigen::LLT<Matrix> llt_;
  Vector alpha_;
};

SurrogateFitter kriging(const Vector& range) {
  return [range](const Matrix& x, const Matrix& y) {
    std::vector<Surrogate> models;
    for (Eigen::Index j = 0; j < y.cols(); ++j) models.emplace_back(Kriging(x, y.col(j), range));
    return models;
  };
}

OptimizationProblem branin_problem() {
  return {.parameters = ParameterSpace({{.name = "a", .lower = -5.0, .upper = 10.0},
                                        {.name = "b", .lower = 0.0, .upper = 15.0}}),
          .responses = {"branin"}};
}

const Vector kBraninRange{{15.0, 15.0}};
const BayesianOptimizationOptions kQuick{
    .propose = {.candidates = 200, .polished = 2, .polish_evaluations = 60}};

BayesianOptimizer branin_optimizer() {
  return {branin_problem(), kriging(kBraninRange), kQuick};
}

Vector answer(const Trial& trial) {
  return Vector::Constant(1, test::branin(trial.x));
}

class TemporaryFile {
 public:
  TemporaryFile()
      : path_(std::filesystem::temp_directory_path() /
              ("repose_optimizer_" + std::to_string(::getpid()) + ".h5")) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

TEST(BayesianOptimizer, FindsTheMinimumOfBraninInFortyRuns) {
  BayesianOptimizer optimizer = branin_optimizer();
  double best = 1e300;
  for (int run = 0; run < 40; ++run) {
    const Trial trial = optimizer.ask()[0];
    optimizer.tell(trial.id, answer(trial));
    best = std::min(best, test::branin(trial.x));
  }
  EXPECT_LT(best - 0.397887357729738, 0.01);
  const auto recommended = optimizer.recommend();
  EXPECT_NEAR(test::branin(recommended.x), best, 1e-3);
  EXPECT_NEAR(recommended.objective.mean, best, 1e-2);
}

TEST(BayesianOptimizer, GoesOnWithTheSameBitsFromItsFile) {
  BayesianOptimizer straight = branin_optimizer();
  BayesianOptimizer interrupted = branin_optimizer();
  const TemporaryFile file;
  const auto step = [](BayesianOptimizer& optimizer, int count) {
    const auto asked = optimizer.ask(count);
    for (std::size_t i = 0; i < asked.size(); ++i) {  // every batch leaves a failure and a gap
      if (i == 1) continue;
      if (i == 2)
        optimizer.tell_failed(asked[i].id);
      else
        optimizer.tell(asked[i].id, answer(asked[i]));
    }
  };
  for (const int count : {6, 3, 4}) {
    step(straight, count);
    step(interrupted, count);
    interrupted.save(file.path());
    interrupted = BayesianOptimizer::load(file.path(), kriging(kBraninRange));
  }
  ASSERT_EQ(straight.trials().size(), interrupted.trials().size());
  const auto next = straight.ask(2);
  const auto same = interrupted.ask(2);
  for (std::size_t i = 0; i < next.size(); ++i) {
    EXPECT_EQ(next[i].x, same[i].x);
    EXPECT_EQ(next[i].merit, same[i].merit);
    EXPECT_EQ(next[i].id, same[i].id);
  }
}

TEST(BayesianOptimizer, KeepsItsWholeProblemInTheFile) {
  const ParameterSpace space(
      {{.name = "friction", .lower = 0.1, .upper = 0.9},
       {.name = "modulus", .lower = 1e6, .upper = 1e9, .scale = Scale::log, .unit = "Pa"},
       {.name = "layers", .lower = 1, .upper = 4, .kind = ParameterKind::integer},
       {.name = "step",
        .lower = 0.1,
        .upper = 0.3,
        .kind = ParameterKind::levels,
        .levels = {0.1, 0.2, 0.3}},
       {.name = "mode", .kind = ParameterKind::categorical, .categories = {"mixed", "layered"}}},
      {{"rolling", 0.2}}, {{.name = "mean", .sources = {"friction", "rolling"}}},
      {{.name = "share", .coefficients = {{"friction", 1.0}, {"step", 2.0}}, .upper = 1.0}});
  const OptimizationProblem problem{
      .parameters = space,
      .responses = {"angle", "friction"},  // a response may be called as a parameter is
      .targets = {{.name = "angle", .value = 30.0, .weight = 2.0, .standard_deviation = 0.5},
                  {.name = "friction", .value = 0.0, .scale = 3.0, .penalty = Penalty::squared}}};
  BayesianOptimizationOptions options{.initial_points = 7, .seed = 0xfedcba9876543210U};
  options.propose.acquisition = Acquisition::lower_confidence_bound;
  options.propose.belief = Belief::worst_lie;
  options.propose.repeats = Repeats::allow;
  options.propose.kappa = 1.25;
  options.propose.failed_distance = 0.03;
  options.propose.minimum_distance = 0.002;
  options.propose.candidates = 123;
  options.propose.polished = 4;
  options.propose.polish_evaluations = 55;
  options.propose.draws = 67;
  BayesianOptimizer optimizer(problem, kriging(Vector::Ones(5)), options);
  optimizer.ask(9);
  optimizer.tell(3, Vector{{31.0, 2.0}});
  optimizer.tell_failed(5);
  const TemporaryFile file;
  optimizer.save(file.path());
  const auto loaded = BayesianOptimizer::load(file.path(), kriging(Vector::Ones(5)));
  const ParameterSpace& read = loaded.problem().parameters;
  ASSERT_EQ(read.names(), space.names());
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(read.parameters()[k].kind, space.parameters()[k].kind);
    EXPECT_EQ(read.parameters()[k].scale, space.parameters()[k].scale);
    EXPECT_EQ(read.parameters()[k].lower, space.parameters()[k].lower);
    EXPECT_EQ(read.parameters()[k].upper, space.parameters()[k].upper);
    EXPECT_EQ(read.parameters()[k].unit, space.parameters()[k].unit);
    EXPECT_EQ(read.parameters()[k].levels, space.parameters()[k].levels);
    EXPECT_EQ(read.parameters()[k].categories, space.parameters()[k].categories);
  }
  EXPECT_EQ(read.fixed(), space.fixed());
  ASSERT_EQ(read.ties().size(), 1U);
  EXPECT_EQ(read.ties()[0].name, "mean");
  EXPECT_EQ(read.ties()[0].sources, space.ties()[0].sources);
  ASSERT_EQ(read.constraints().size(), 1U);
  EXPECT_EQ(read.constraints()[0].coefficients, space.constraints()[0].coefficients);
  EXPECT_EQ(read.constraints()[0].upper, 1.0);
  EXPECT_TRUE(std::isinf(read.constraints()[0].lower));
  ASSERT_EQ(loaded.problem().targets.size(), 2U);
  EXPECT_EQ(loaded.problem().targets[0].standard_deviation, 0.5);
  EXPECT_EQ(loaded.problem().targets[0].weight, 2.0);
  EXPECT_EQ(loaded.problem().targets[1].scale, 3.0);
  EXPECT_EQ(loaded.problem().targets[1].penalty, Penalty::squared);
  EXPECT_EQ(loaded.options().seed, options.seed);
  EXPECT_EQ(loaded.options().initial_points, 7);
  EXPECT_EQ(loaded.options().propose.acquisition, Acquisition::lower_confidence_bound);
  EXPECT_EQ(loaded.options().propose.belief, Belief::worst_lie);
  EXPECT_EQ(loaded.options().propose.repeats, Repeats::allow);
  EXPECT_EQ(loaded.options().propose.kappa, 1.25);
  EXPECT_EQ(loaded.options().propose.failed_distance, 0.03);
  EXPECT_EQ(loaded.options().propose.minimum_distance, 0.002);
  EXPECT_EQ(loaded.options().propose.candidates, 123);
  EXPECT_EQ(loaded.options().propose.polished, 4);
  EXPECT_EQ(loaded.options().propose.polish_evaluations, 55);
  EXPECT_EQ(loaded.options().propose.draws, 67);
  ASSERT_EQ(loaded.trials().size(), 9U);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(loaded.trials()[i].x, optimizer.trials()[i].x);
    EXPECT_EQ(loaded.trials()[i].state, optimizer.trials()[i].state);
  }
  EXPECT_EQ(loaded.trials()[2].y, optimizer.trials()[2].y);
}

TEST(BayesianOptimizer, ProposesWholeNumbersLevelsAndCategoriesThatObeyConstraints) {
  const ParameterSpace space(
      {{.name = "a", .lower = 0.0, .upper = 1.0},
       {.name = "b", .lower = 1e-3, .upper = 1.0, .scale = Scale::log},
       {.name = "n", .lower = 1, .upper = 5, .kind = ParameterKind::integer},
       {.name = "mode", .kind = ParameterKind::categorical, .categories = {"x", "y", "z"}}},
      {}, {}, {{.name = "sum", .coefficients = {{"a", 1.0}, {"n", 0.2}}, .upper = 1.2}});
  BayesianOptimizer optimizer({.parameters = space, .responses = {"f"}},
                              kriging(Vector{{1.0, 1.0, 4.0, 2.0}}), kQuick);
  const auto f = [](const Vector& x) {
    return std::pow(x[0] - 0.4, 2) + std::pow(std::log10(x[1]) + 2.0, 2) + std::pow(x[2] - 4.0, 2) +
           (x[3] == 1.0 ? 0.0 : 1.0);
  };
  for (int round = 0; round < 12; ++round)
    for (const Trial& trial : optimizer.ask(2)) {
      EXPECT_TRUE(space.obeys_constraints(trial.x));
      EXPECT_EQ(trial.x[2], std::round(trial.x[2]));
      EXPECT_TRUE(trial.x[3] == 0.0 || trial.x[3] == 1.0 || trial.x[3] == 2.0);
      EXPECT_GE(trial.x[1], 1e-3);
      EXPECT_LE(trial.x[1], 1.0);
      optimizer.tell(trial.id, Vector::Constant(1, f(trial.x)));
    }
  EXPECT_LT(optimizer.recommend().objective.mean, 0.3);
}

TEST(BayesianOptimizer, LearnsFromRunsMadeAnyway) {
  BayesianOptimizer optimizer = branin_optimizer();
  EXPECT_EQ(optimizer.add(Vector{{3.14, 2.27}}, Vector::Constant(1, 0.398)), 1);
  EXPECT_EQ(optimizer.recommend().trial, 1);
  EXPECT_EQ(optimizer.ask()[0].id, 2);
  EXPECT_THROW(optimizer.add(Vector{{30.0, 2.0}}, Vector::Constant(1, 0.4)), InputError);
}

TEST(BayesianOptimizer, RefusesRunsAtValuesThatParametersDoNotTake) {
  const ParameterSpace space(
      {{.name = "n", .lower = 1, .upper = 5, .kind = ParameterKind::integer},
       {.name = "h", .kind = ParameterKind::levels, .levels = {0.1, 0.4}},
       {.name = "mode", .kind = ParameterKind::categorical, .categories = {"x", "y"}}});
  BayesianOptimizer optimizer({.parameters = space, .responses = {"f"}}, kriging(Vector::Ones(3)));
  const Vector y = Vector::Zero(1);
  EXPECT_EQ(optimizer.add(Vector{{2.0, 0.4, 1.0}}, y), 1);
  EXPECT_THROW(optimizer.add(Vector{{2.5, 0.4, 1.0}}, y), InputError);
  EXPECT_THROW(optimizer.add(Vector{{2.0, 0.2, 1.0}}, y), InputError);
  EXPECT_THROW(optimizer.add(Vector{{2.0, 0.4, 0.5}}, y), InputError);
  EXPECT_THROW(optimizer.add(Vector{{2.0, 0.4, 2.0}}, y), InputError);
  EXPECT_EQ(optimizer.trials().size(), 1U);
}

TEST(BayesianOptimizer, AsksForNoInitialPointTwiceWhileOthersAreLeft) {
  const ParameterSpace six(
      {{.name = "n", .lower = 1, .upper = 3, .kind = ParameterKind::integer},
       {.name = "mode", .kind = ParameterKind::categorical, .categories = {"x", "y"}}});
  BayesianOptimizer optimizer({.parameters = six, .responses = {"f"}}, kriging(Vector::Ones(2)));
  optimizer.add(Vector{{2.0, 1.0}}, Vector::Zero(1));
  optimizer.ask(2);
  optimizer.ask(3);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(optimizer.trials()[i].x, optimizer.trials()[j].x);
  EXPECT_EQ(optimizer.ask(2).size(), 2U);  // none is left
}

TEST(BayesianOptimizer, GoesOnWithInitialPointsUntilTheFitterHasEnough) {
  const auto hungry = [](const Matrix& x, const Matrix& y) {
    if (x.rows() < 6) throw InputError("six runs at least");
    return kriging(kBraninRange)(x, y);
  };
  BayesianOptimizationOptions options = kQuick;
  options.initial_points = 8;
  BayesianOptimizer optimizer(branin_problem(), hungry, options);
  for (const Trial& trial : optimizer.ask(8)) {  // five of eight are done
    if (trial.id <= 5)
      optimizer.tell(trial.id, answer(trial));
    else
      optimizer.tell_failed(trial.id);
  }
  const Trial ninth = optimizer.ask()[0];
  EXPECT_TRUE(std::isnan(ninth.merit));  // one more by chance
  optimizer.tell(ninth.id, answer(ninth));
  EXPECT_FALSE(std::isnan(optimizer.ask()[0].merit));
}

TEST(BayesianOptimizer, RecommendsAPointThatObeysTheConstraints) {
  const ParameterSpace space({{.name = "a", .lower = 0.0, .upper = 1.0}}, {}, {},
                             {{.name = "c", .coefficients = {{"a", 1.0}}, .upper = 0.5}});
  BayesianOptimizer optimizer({.parameters = space, .responses = {"f"}}, kriging(Vector::Ones(1)));
  optimizer.add(Vector{{0.9}}, Vector::Constant(1, 0.0));
  EXPECT_EQ(optimizer.recommend().trial, 1);  // there is no other
  optimizer.add(Vector{{0.2}}, Vector::Constant(1, 5.0));
  EXPECT_EQ(optimizer.recommend().trial, 2);
}

TEST(BayesianOptimizer, KeepsConstraintsOfOneNameApartInItsFile) {
  const ParameterSpace space(
      {{.name = "a", .lower = 0.0, .upper = 1.0}, {.name = "b", .lower = 0.0, .upper = 1.0}}, {},
      {},
      {{.name = "c", .coefficients = {{"a", 1.0}}, .upper = 0.5},
       {.name = "c", .coefficients = {{"b", 1.0}}, .lower = 0.25}});
  BayesianOptimizer optimizer({.parameters = space, .responses = {"f"}}, kriging(Vector::Ones(2)));
  const TemporaryFile file;
  optimizer.save(file.path());
  const auto loaded = BayesianOptimizer::load(file.path(), kriging(Vector::Ones(2)));
  const auto& read = loaded.problem().parameters.constraints();
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].upper, 0.5);
  EXPECT_EQ(read[1].lower, 0.25);
  EXPECT_EQ(read[1].coefficients, space.constraints()[1].coefficients);
}

TEST(BayesianOptimizer, RefusesWhatItCannotUse) {
  EXPECT_THROW(
      BayesianOptimizer({.parameters = branin_problem().parameters}, kriging(kBraninRange)),
      InputError);
  EXPECT_THROW(
      BayesianOptimizer({.parameters = branin_problem().parameters, .responses = {"a", "b"}},
                        kriging(kBraninRange)),
      InputError);
  BayesianOptimizer optimizer = branin_optimizer();
  EXPECT_THROW(optimizer.recommend(), InputError);
  EXPECT_THROW(optimizer.ask(0), InputError);
  optimizer.ask(2);
  EXPECT_THROW(optimizer.tell(3, Vector::Zero(1)), InputError);
  EXPECT_THROW(optimizer.tell(1, Vector::Zero(2)), InputError);
  EXPECT_THROW(optimizer.tell(1, Vector::Constant(1, NAN)), InputError);
  optimizer.tell(1, Vector::Zero(1));
  EXPECT_THROW(optimizer.tell(1, Vector::Zero(1)), InputError);
}

TEST(BayesianOptimizer, RefusesFilesThatAreNotItsOwn) {
  const TemporaryFile file;
  EXPECT_THROW(BayesianOptimizer::load(file.path(), kriging(kBraninRange)), StorageError);
  std::ofstream(file.path()) << "no HDF5";
  EXPECT_THROW(BayesianOptimizer::load(file.path(), kriging(kBraninRange)), StorageError);
}

TEST(SearchSpace, TakesNaturalValuesToCoordinatesAndBack) {
  const SearchSpace space(ParameterSpace(
      {{.name = "modulus", .lower = 1e6, .upper = 1e9, .scale = Scale::log},
       {.name = "n", .lower = 2, .upper = 9, .kind = ParameterKind::integer},
       {.name = "h",
        .lower = 1.0,
        .upper = 10.0,
        .kind = ParameterKind::levels,
        .levels = {1.0, 2.0, 10.0}},
       {.name = "b", .lower = 0.1, .upper = 0.9, .scale = Scale::log}},
      {{"f", 0.5}}, {{.name = "t", .sources = {"b", "f"}}},
      {{.name = "c", .coefficients = {{"t", 2.0}, {"n", 1.0}}, .lower = 3.0, .upper = 9.0}}));
  const Vector x{{3e7, 5.0, 10.0, 0.3}};
  const Vector z = space.coordinates(x);
  EXPECT_NEAR(z[0], std::log(3e7), 1e-14);
  EXPECT_EQ(z[2], 2.0);
  EXPECT_EQ(z[3], 0.3);  // stands in a constraint: linear
  EXPECT_NEAR((space.natural(z) - x).cwiseQuotient(x).cwiseAbs().maxCoeff(), 0.0, 1e-14);
  // 2 t + n = b + f + n
  ASSERT_EQ(space.set().inequalities.size(), 2U);
  EXPECT_NEAR(violation(z, space.set()), 0.0, 0.0);
  const auto& upper = space.set().inequalities[0];
  EXPECT_NEAR(upper.coefficients.dot(z) - upper.bound, 0.3 + 0.5 + 5.0 - 9.0,
              1e-10);  // 1e-12 of the terms is rounding
  const auto& lower = space.set().inequalities[1];
  EXPECT_NEAR(lower.coefficients.dot(z) - lower.bound, 3.0 - (0.3 + 0.5 + 5.0), 1e-10);
}

TEST(SearchSpace, RefusesConstraintsOnUnequallySpacedLevels) {
  EXPECT_THROW(SearchSpace(ParameterSpace(
                   {{.name = "h",
                     .lower = 1.0,
                     .upper = 10.0,
                     .kind = ParameterKind::levels,
                     .levels = {1.0, 2.0, 10.0}}},
                   {}, {}, {{.name = "c", .coefficients = {{"h", 1.0}}, .upper = 5.0}})),
               InputError);
}

}  // namespace
}  // namespace repose::opt
