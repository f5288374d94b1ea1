// What transfer is worth on a table of several groups.
#include "repose/surrogate/transfer_validation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "grouped_screening.hpp"
#include "repose/base/error.hpp"
#include "transfer_data.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;
using test::bumps;
using test::sampled;

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

/// Ranges as a table without declarations has them: of all rows.
void take_ranges(TrainingSet& data) {
  data = with_own_ranges(std::move(data), {true, true});
}

/// Of 15 rows of a group 14 are given, 1 is not. Its response moves nothing but the error, its
/// inputs nothing but its own prediction; any other row moves what the model is fitted to.
TEST(TransferValidation, DoesNotSeeTheRowsItIsJudgedBy) {
  TransferValidationOptions options = quick({14});
  options.model = "linear-svm";
  options.methods = {retrained, weighted};
  options.seeds = 1;
  options.undeclared = {true, true};
  TrainingSet data = three_groups();
  take_ranges(data);
  const auto before = validate_transfer(data, options);
  const auto& retrained_before = before.scores[2];
  const auto& weighted_before = before.scores[5];
  int unseen = 0;
  for (Eigen::Index i = 2; i < 45; i += 3) {
    TrainingSet moved = data;
    moved.y[i] += 1000.0;
    const auto after = validate_transfer(moved, options);
    if (after.scores[2].validation.rmse.mean != retrained_before.validation.rmse.mean) continue;
    ++unseen;
    for (const std::size_t s : {std::size_t{2}, std::size_t{5}})
      EXPECT_NEAR(after.scores[s].unseen.rmse.mean, 1000.0,
                  before.scores[s].unseen.rmse.mean + 1e-9);
    EXPECT_EQ(after.scores[5].correlation.mean, weighted_before.correlation.mean);
    moved = data;
    moved.x(i, 0) = 7.0;
    take_ranges(moved);
    EXPECT_EQ(validate_transfer(moved, options).scores[2].validation.rmse.mean,
              retrained_before.validation.rmse.mean);
  }
  EXPECT_EQ(unseen, 1);
}

/// Without rows of a group the model is that of the others, whose ranges are theirs.
TEST(TransferValidation, ScalesInputsByTheRowsOfTheSource) {
  TransferValidationOptions options = quick({0});
  options.methods = {retrained};
  options.undeclared = {true, true};
  TrainingSet data = three_groups();
  take_ranges(data);
  const TransferScore before = validate_transfer(data, options).scores[2];
  for (Eigen::Index i = 2; i < 45; i += 3) data.x(i, 0) *= 5.0;
  take_ranges(data);
  const TransferScore after = validate_transfer(data, options).scores[2];
  EXPECT_EQ(before.validation.rmse.mean, after.validation.rmse.mean);
}

TEST(TransferValidation, OfAGroupWithOneResponseHasFigures) {
  TrainingSet data = three_groups();
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < 45; ++i)
    if (data.groups[static_cast<std::size_t>(i)] < 2) rows.push_back(i);
  data = selected_rows(data, rows);
  for (Eigen::Index i = 0; i < data.rows(); ++i)
    if (data.groups[static_cast<std::size_t>(i)] == 1) data.y[i] = 0.7;
  for (const TransferScore& s : validate_transfer(data, quick({0, 1, 5})).scores) {
    EXPECT_EQ(s.failure, "") << to_string(s.method) << s.samples;
    EXPECT_TRUE(std::isfinite(s.unseen.rmse.mean)) << to_string(s.method) << s.samples;
    if (s.method == retrained) {
      EXPECT_TRUE(std::isfinite(s.validation.rmse.mean)) << s.samples;
    }
  }
}

TEST(TransferValidation, SaysWhyAValidationFailedAndKeepsWhatWasUnseen) {
  TrainingSet data = three_groups();
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < 15; ++i)
    if (data.groups[static_cast<std::size_t>(i)] < 2) rows.push_back(i);
  TransferValidationOptions options = quick({0, 4});
  options.folds = 8;
  options.methods = {retrained};
  const auto result = validate_transfer(selected_rows(data, rows), options);  // 5 of each
  for (const TransferScore& s : result.scores) {
    EXPECT_EQ(s.averaged, 2);
    EXPECT_TRUE(std::isfinite(s.unseen.rmse.mean));
    EXPECT_EQ(s.failure.starts_with("validation: 8 folds of 5 different points"), s.samples == 0)
        << s.failure;
    EXPECT_EQ(std::isnan(s.validation.rmse.mean), s.samples == 0);
  }
  EXPECT_EQ(result.all_seen_failure, "");
}

TEST(TransferValidation, RefusesAtOnceWhatNoModelCanDo) {
  TransferValidationOptions options = quick();
  options.model = "boosted-ensemble";
  options.methods = {weighted, source_basis};
  int fits = 0;
  options.progress = [&fits](double, double, std::string_view) { ++fits; };
  EXPECT_THROW(validate_transfer(three_groups(), options), InputError);
  EXPECT_EQ(fits, 0);
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
  EXPECT_EQ(small->averaged, 0);
  for (const TransferScore& mean : result.means) {
    EXPECT_EQ(mean.averaged, mean.samples == 0 ? 4 : 3);
    EXPECT_EQ(mean.failure.empty(), mean.samples == 0);
  }
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
