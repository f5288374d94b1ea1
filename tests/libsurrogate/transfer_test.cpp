// Transfer of a model to a new configuration, its parts, its files and what it is worth.
#include "repose/surrogate/transfer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>

#include "grouped_screening.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/surrogate/transfer_validation.hpp"
#include "transfer_data.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;
using test::bumps;
using test::sampled;

constexpr TransferMethod kAll[] = {retrained,    target_only,    shift_and_scale,
                                   source_basis, coregionalised, weighted};

double altered(const Vector& x) {
  return 1.0 + 1.5 * bumps(x) + 0.2 * std::cos(4.0 * x[0]);
}

double unrelated(const Vector& x) {
  return std::cos(8.0 * x[1]) * (x[0] - 0.5);
}

struct Case {
  TrainingSet source = sampled(bumps, 40, 0.05, 1);
  PretrainedModel model = pretrained("gpr", source, 1);
  TrainingSet target;
  explicit Case(const test::Function& f = altered, Eigen::Index rows = 8)
      : target(sampled(f, rows, 0.05, 2)) {}
  Transfer by(TransferMethod method) const {
    return transfer(model, source, target, {.method = method});
  }
};

double rmse(const Regressor& model, const test::Function& f) {
  const TrainingSet test = sampled(f, 300, 0.0, 9);
  return std::sqrt((model.predict(test.x) - test.y).squaredNorm() / 300.0);
}

TEST(Transfer, WithoutRowsOfTheTargetIsTheSource) {
  const Case c(altered, 0);
  const Transfer found = c.by(weighted);
  EXPECT_EQ(found.model.predict(c.source.x), c.model.model.predict(c.source.x));
  EXPECT_TRUE(found.parts.empty());
  EXPECT_TRUE(std::isnan(found.correlation));
}

TEST(Transfer, RetrainedKeepsTheHyperparametersAndTakesAllRows) {
  const Case c;
  const TrainingSet both = joined(c.source, c.target);
  const GaussianProcess& source = *gaussian_process(c.model.model);
  const auto expected =
      GaussianProcess::with_parameters(both.x, both.y, both.inputs, source.hyperparameters(),
                                       {.kernel = source.kernel(), .basis = source.basis()});
  const Matrix q = sampled(bumps, 20, 0.0, 3).x;
  EXPECT_EQ(c.by(retrained).model.predict(q), GaussianProcessRegressor(expected).predict(q));
}

TEST(Transfer, ShiftAndScaleFindsThem) {
  Case c;
  c.target.y = 2.0 - 3.0 * c.model.model.predict(c.target.x).array();
  const Matrix q = sampled(bumps, 20, 0.0, 3).x;
  const Vector expected = 2.0 - 3.0 * c.model.model.predict(q).array();
  EXPECT_LT((c.by(shift_and_scale).model.predict(q) - expected).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Transfer, ShiftsAloneBelowFourRows) {
  for (const Eigen::Index rows : {1, 2, 3}) {
    const Case c(altered, rows);
    const Vector source = c.model.model.predict(c.target.x);
    const double shift = (c.target.y - source).mean();
    const Vector added = c.by(shift_and_scale).model.predict(c.target.x) - source;
    EXPECT_LT((added.array() - shift).abs().maxCoeff(), 1e-12);
    EXPECT_GT(std::abs(shift), 0.1);
  }
}

TEST(Transfer, EveryWayPredictsFromEveryNumberOfRowsItAllows) {
  for (const Eigen::Index rows : {1, 2, 3, 4, 8, 25})
    for (const TransferMethod method : kAll) {
      const Case c(altered, rows);
      if (rows < 3 && (method == target_only || method == source_basis)) {
        if (rows == 1) {
          EXPECT_THROW(c.by(method), InputError) << rows << to_string(method);
        }
        continue;
      }
      const Transfer found = c.by(method);
      const Predictions p = found.model.predict_with_variances(c.target.x);
      EXPECT_TRUE(p.mean.allFinite()) << rows << to_string(method);
      EXPECT_GE(p.function_variance.minCoeff(), 0.0) << rows << to_string(method);
      EXPECT_TRUE((p.observation_variance.array() >= p.function_variance.array()).all())
          << rows << to_string(method);
      EXPECT_TRUE(found.correlation >= -1.0 && found.correlation <= 1.0) << rows;
    }
}

TEST(Transfer, WeightsItsPartsByTheirErrors) {
  const Transfer found = Case().by(weighted);
  ASSERT_EQ(found.parts.size(), 3u);
  double sum = 0.0;
  for (const TransferPart& part : found.parts) {
    EXPECT_EQ(part.failure, "");
    EXPECT_GT(part.left_out_rmse, 0.0);
    sum += part.weight;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  for (const TransferPart& a : found.parts)
    for (const TransferPart& b : found.parts)  // mse^(-n/10), 8 rows
      EXPECT_NEAR(a.weight / b.weight, std::pow(b.left_out_rmse / a.left_out_rmse, 1.6), 1e-9);
}

TEST(Transfer, IsBetterThanRetrainingOnARelatedTargetAndSafeOnAnother) {
  const Case related, other(unrelated, 20);
  EXPECT_LT(rmse(related.by(weighted).model, altered),
            0.5 * rmse(related.by(retrained).model, altered));
  EXPECT_LT(rmse(related.by(weighted).model, altered),
            0.7 * rmse(related.by(target_only).model, altered));
  EXPECT_LT(rmse(other.by(weighted).model, unrelated),
            1.15 * rmse(other.by(target_only).model, unrelated));
  EXPECT_GT(related.by(weighted).correlation, 0.9);
  EXPECT_LT(std::abs(other.by(weighted).correlation), 0.5);
}

TEST(Transfer, OfTreesWeighsWhatTreesCanDo) {
  Case c(altered, 12);
  c.model = pretrained("bagged-ensemble", c.source, 1);
  const Transfer found = c.by(weighted);
  ASSERT_EQ(found.parts.size(), 3u);
  EXPECT_EQ(found.parts[0].method, retrained);
  EXPECT_EQ(found.parts[2].method, shift_and_scale);
  EXPECT_TRUE(found.model.predict(c.target.x).allFinite());
  EXPECT_GT(found.correlation, 0.5);
  EXPECT_TRUE(std::isnan(found.correlation_deviation));
  EXPECT_THROW(c.by(coregionalised), InputError);
  EXPECT_THROW(c.by(source_basis), InputError);
}

TEST(Transfer, LeavesOutWaysThatCannotBeFittedAndSaysWhy) {
  Case c(altered, 6);
  c.source.y.setConstant(1.0);  // the source's mean is no regression function besides the constant
  c.model = pretrained("gpr", c.source, 1);
  const Transfer found = c.by(weighted);
  const auto part = std::find_if(found.parts.begin(), found.parts.end(),
                                 [](const auto& p) { return p.method == source_basis; });
  ASSERT_NE(part, found.parts.end());
  EXPECT_NE(part->failure, "");
  EXPECT_EQ(part->weight, 0.0);
  EXPECT_TRUE(found.model.predict(c.target.x).allFinite());
}

TEST(Transfer, RefusesOtherInputs) {
  Case c;
  c.target.inputs[0] = {.levels = {"a", "b"}};
  c.target.x.col(0).setZero();
  EXPECT_THROW(c.by(weighted), InputError);
  EXPECT_THROW(transfer_method_named("magic"), InputError);
  for (const TransferMethod method : kAll)
    EXPECT_EQ(transfer_method_named(to_string(method)), method);
}

std::filesystem::path file_of_this_test() {
  return std::filesystem::temp_directory_path() /
         (std::string("repose_transfer_") +
          ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
          std::to_string(::getpid()) + ".h5");
}

TEST(TransferFile, GivesBackEveryWayToTheBit) {
  const auto path = file_of_this_test();
  const Matrix q = sampled(bumps, 20, 0.0, 3).x;
  for (const char* source : {"gpr", "boosted-ensemble"})
    for (const TransferMethod method : kAll) {
      Case c;
      c.model = pretrained(source, c.source, 1);
      if (gaussian_process(c.model.model) == nullptr &&
          (method == source_basis || method == coregionalised))
        continue;
      const Regressor model = c.by(method).model;
      save_regressor(path, {model, {"a", "b"}, "y"});
      const NamedRegressor loaded = load_regressor(path);
      EXPECT_EQ(loaded.model.describe(), model.describe());
      EXPECT_EQ(loaded.model.predict(q), model.predict(q)) << source << to_string(method);
      const Vector before = model.predict_with_variances(q).observation_variance;
      const Vector after = loaded.model.predict_with_variances(q).observation_variance;
      for (Eigen::Index i = 0; i < q.rows(); ++i)
        EXPECT_TRUE(before[i] == after[i] || (std::isnan(before[i]) && std::isnan(after[i])))
            << source << to_string(method);
    }
  std::filesystem::remove(path);
}

TEST(FirstTargetRuns, TakeTheRowThatLeavesTheSmallestVariance) {
  const TrainingSet source = sampled(bumps, 40, 0.05, 1);
  const auto process = GaussianProcess::fit(source.x, source.y, source.inputs);
  const Matrix candidates = sampled(bumps, 30, 0.0, 5).x;
  const auto order = first_target_runs(process, candidates, 30);
  EXPECT_EQ(std::set<Eigen::Index>(order.begin(), order.end()).size(), 30u);
  const auto first = first_target_runs(process, candidates, 3);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), order.begin()));
  // what is simulated already need not be simulated again: of two equal rows one is worth nothing
  Matrix twice(31, 2);
  twice << candidates, candidates.row(order[0]);
  const auto next = first_target_runs(process, twice, 10, candidates.row(order[0]));
  EXPECT_EQ(next[0], order[1]);
  EXPECT_EQ(std::count(next.begin(), next.end(), order[0]), 0);
  EXPECT_EQ(std::count(next.begin(), next.end(), 30), 0);
  EXPECT_THROW(first_target_runs(process, candidates, 31), InputError);
}

TEST(Joined, KeepsPointsApartAndRepeatsTogether) {
  TrainingSet a = sampled(bumps, 3, 0.0, 1), b = sampled(bumps, 2, 0.0, 2);
  a.replicates = {5, 5, 9};
  b.x.row(1) = b.x.row(0);
  const TrainingSet both = joined(a, b);
  EXPECT_EQ(both.rows(), 5);
  EXPECT_EQ(both.replicates, (std::vector<Eigen::Index>{0, 0, 1, 2, 2}));
  EXPECT_TRUE(both.groups.empty());
}

TransferValidationOptions quick(std::vector<int> samples = {0, 5}) {
  return {.samples = std::move(samples), .seeds = 2, .folds = 3};
}

/// Three groups of a function with a shift each.
TrainingSet three_groups() {
  TrainingSet data = sampled(bumps, 45, 0.05, 4);
  for (Eigen::Index i = 0; i < 45; ++i) {
    data.groups.push_back(i % 3);
    data.y[i] += static_cast<double>(i % 3);
  }
  return data;
}

TEST(TransferValidation, HasALineForEveryGroupAndNumberOfRows) {
  const auto result = validate_transfer(three_groups(), quick());
  ASSERT_EQ(result.scores.size(), 12u);  // methods, groups, numbers
  ASSERT_EQ(result.means.size(), 4u);
  for (const TransferScore& s : result.scores) {
    EXPECT_EQ(s.failure, "");
    EXPECT_GT(s.unseen.rmse.mean, 0.0);
    EXPECT_EQ(std::isnan(s.validation.rmse.mean), s.method != retrained);
    EXPECT_EQ(std::isnan(s.correlation.mean), s.samples == 0);
  }
  double mean = 0.0;
  for (const TransferScore& s : result.scores)
    if (s.method == weighted && s.samples == 5) mean += s.unseen.rmse.mean / 3.0;
  EXPECT_NEAR(result.means[3].unseen.rmse.mean, mean, 1e-12);
  EXPECT_EQ(result.means[3].samples, 5);
  EXPECT_GT(result.all_seen.rmse.mean, 0.0);
}

TEST(TransferValidation, DoesNotDependOnTheNumberOfThreads) {
  TransferValidationOptions options = quick();
  const auto one = validate_transfer(three_groups(), options);
  options.threads = 3;
  const auto three = validate_transfer(three_groups(), options);
  for (std::size_t i = 0; i < one.scores.size(); ++i)
    EXPECT_EQ(one.scores[i].unseen.rmse.mean, three.scores[i].unseen.rmse.mean);
  EXPECT_EQ(one.all_seen.rmse.mean, three.all_seen.rmse.mean);
}

/// With all responses of a group 1000 larger, what is predicted from the others stays: every error
/// is 1000 larger, and their root mean square 1000 up to the root mean square before.
TEST(TransferValidation, DoesNotSeeTheRowsItIsJudgedBy) {
  TrainingSet data = three_groups();
  TransferValidationOptions options = quick({0});
  options.methods = {retrained};
  const TransferScore before = validate_transfer(data, options).scores[2];
  for (Eigen::Index i = 2; i < 45; i += 3) data.y[i] += 1000.0;
  const TransferScore after = validate_transfer(data, options).scores[2];
  EXPECT_LE(std::abs(after.unseen.rmse.mean - 1000.0), before.unseen.rmse.mean);
  EXPECT_EQ(before.validation.rmse.mean, after.validation.rmse.mean);
}

TEST(TransferValidation, SaysWhichGroupsAreTooSmall) {
  TrainingSet data = three_groups();
  data.groups[0] = 7;  // one row
  const auto result = validate_transfer(data, quick({0, 5}));
  const auto small = std::find_if(result.scores.begin(), result.scores.end(),
                                  [](const auto& s) { return s.group == 7 && s.samples == 5; });
  ASSERT_NE(small, result.scores.end());
  EXPECT_EQ(small->failure, "it has 1 rows: none are left unseen");
  EXPECT_TRUE(std::isnan(small->unseen.rmse.mean));
  EXPECT_THROW(validate_transfer(data, quick({20})), InputError);
  EXPECT_THROW(validate_transfer(data, quick({})), InputError);
  std::fill(data.groups.begin(), data.groups.end(), 1);
  EXPECT_THROW(validate_transfer(data, quick()), InputError);
}

TEST(TransferValidation, GainsFromRowsOnTheTableOfTheThesis) {
  TransferValidationOptions options = quick({0, 10});
  options.methods = {weighted};
  options.order = TransferValidationOptions::Order::variance;
  options.seeds = 1;
  options.threads = 0;
  const auto result = validate_transfer(test::grouped_screening(1).data, options);
  EXPECT_LT(result.means[1].unseen.rmse.mean, 0.5 * result.means[0].unseen.rmse.mean);
  EXPECT_GT(result.means[1].correlation.mean, 0.7);
}

}  // namespace
}  // namespace repose::surrogate
