// Transfer of a model to a new configuration, its parts, its files and what it is worth.
#include "repose/surrogate/transfer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <tuple>

#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"
#include "transfer_data.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;
using test::altered;
using test::bumps;
using test::sampled;
using Case = test::TransferCase;

constexpr TransferMethod kAll[] = {retrained,    target_only,    shift_and_scale,
                                   source_basis, coregionalised, weighted};

double unrelated(const Vector& x) {
  return std::cos(8.0 * x[1]) * (x[0] - 0.5);
}

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

TEST(Transfer, ShiftsAloneBelowFourPointsHoweverOftenRepeated) {
  Case c(altered, 3);
  const std::vector<Eigen::Index> twice{0, 1, 2, 0, 1, 2};
  c.target = selected_rows(c.target, twice);
  const Vector source = c.model.model.predict(c.target.x);
  const Vector added = c.by(weighted).model.predict(c.target.x) - source;
  EXPECT_LT((added.array() - (c.target.y - source).mean()).abs().maxCoeff(), 1e-12);
}

TEST(Transfer, EveryWayPredictsFromEveryNumberOfRowsItAllows) {
  for (const Eigen::Index rows : {1, 2, 3, 4, 8, 25})
    for (const TransferMethod method : kAll) {
      const Case c(altered, rows);
      // a process needs a point more than coefficients: one, with the source as a function two
      if (rows < (method == target_only ? 2 : method == source_basis ? 3 : 1)) {
        EXPECT_THROW(c.by(method), InputError) << rows << to_string(method);
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

/// mse^(-n/10) at eight points; shift-and-scale and retrained count where their error is below 0.4
/// of that of target_only.
TEST(Transfer, WeightsItsPartsByTheirErrors) {
  const auto checked = [](const Transfer& found) {
    EXPECT_EQ(found.parts.size(), 5u);
    double sum = 0.0;
    for (const TransferPart& part : found.parts) {
      EXPECT_EQ(part.failure, "");
      EXPECT_GT(part.left_out_rmse, 0.0);
      sum += part.weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    for (const TransferPart& a : found.parts)
      for (const TransferPart& b : found.parts)
        if (a.weight > 0.0 && b.weight > 0.0) {
          EXPECT_NEAR(a.weight / b.weight, std::pow(b.left_out_rmse / a.left_out_rmse, 1.6), 1e-9);
        }
    for (const TransferPart& part : found.parts) {
      const bool holds_on = part.method == retrained || part.method == shift_and_scale;
      const bool far_better = part.left_out_rmse < 0.4 * found.parts[0].left_out_rmse;
      EXPECT_EQ(part.weight > 0.0, !holds_on || far_better) << to_string(part.method);
    }
    return found.parts[4];
  };
  const TransferPart shifted = checked(Case().by(weighted));
  EXPECT_EQ(shifted.method, retrained);
  EXPECT_EQ(shifted.weight, 0.0);
  EXPECT_GT(checked(Case(bumps).by(weighted)).weight, 0.1);
}

/// Two parts predict a constant target exactly, and are not taken for no better than the third.
TEST(Transfer, WeighsPartsOfAConstantTargetByTheirErrorsToo) {
  for (const double level : {0.3, 0.0}) {
    Case c;
    c.target.y.setConstant(level);
    const Transfer found = c.by(weighted);
    const double least = std::max(1e-12 * level * level, std::numeric_limits<double>::min());
    const auto error = [least](const TransferPart& part) {
      return std::max(part.left_out_rmse * part.left_out_rmse, least);
    };
    double best = 1e300, sum = 0.0;
    std::vector<TransferPart> counting;
    for (const TransferPart& part : found.parts)
      if (part.weight > 0.0) counting.push_back(part);
    for (const TransferPart& part : counting) best = std::min(best, error(part));
    for (const TransferPart& part : counting) sum += std::pow(error(part) / best, -0.8);
    for (const TransferPart& part : counting)
      EXPECT_NEAR(part.weight, std::pow(error(part) / best, -0.8) / sum, 1e-12) << level;
    EXPECT_EQ(found.parts[2].method, coregionalised);  // the others find a constant exactly
    EXPECT_LT(found.parts[2].weight, 0.01) << level;
    EXPECT_LT((found.model.predict(c.source.x).array() - level).abs().maxCoeff(), 0.01) << level;
  }
}

TEST(Transfer, CountsPointsOnceInWeightsHoweverOftenRepeated) {
  Case c;
  std::vector<Eigen::Index> twice(16);
  for (std::size_t i = 0; i < 16; ++i) twice[i] = static_cast<Eigen::Index>(i % 8);
  c.target = selected_rows(c.target, twice);
  const Transfer found = c.by(weighted);
  for (const TransferPart& a : found.parts)
    for (const TransferPart& b : found.parts)
      if (a.weight > 0.0 && b.weight > 0.0) {
        EXPECT_NEAR(a.weight / b.weight, std::pow(b.left_out_rmse / a.left_out_rmse, 1.6), 1e-9);
      }
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
  EXPECT_EQ(found.parts[1].method, shift_and_scale);
  EXPECT_EQ(found.parts[2].method, retrained);
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

std::string refusal_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Transfer, RefusesOtherInputsByTheirNumber) {
  const std::vector<std::pair<Input, const char*>> others{
      {{.levels = {"a", "b"}}, "input 1 of the target has another levels"},
      {{.lower = 0.5}, "input 1 of the target has another range"},
      {{.lower = 0.1, .scale = Scale::log}, "input 1 of the target has another scale"}};
  for (const auto& [input, sentence] : others) {
    Case c;
    c.target.inputs[0] = input;
    c.target.x.col(0).setOnes();
    EXPECT_EQ(refusal_of([&] { c.by(weighted); }).find(sentence), 0u) << sentence;
  }
}

TEST(Transfer, RefusesWhatASourceCannotGive) {
  EXPECT_NE(refusal_of([] {
              check_possible(source_basis, "boosted-ensemble");
            }).find("boosted-ensemble is none"),
            std::string::npos);
  for (const TransferMethod method : kAll) EXPECT_NO_THROW(check_possible(method, "gpr"));
  EXPECT_NO_THROW(check_possible(weighted, "boosted-ensemble"));
  EXPECT_THROW(transfer_method_named("magic"), InputError);
  for (const TransferMethod method : kAll)
    EXPECT_EQ(transfer_method_named(to_string(method)), method);
}

TEST(Transfer, RetrainsAProcessOfAConstantResponse) {
  Case c(altered, 6);
  c.source.y.setConstant(1.0);
  c.model = pretrained("gpr", c.source, 1);
  const Regressor model = c.by(retrained).model;
  EXPECT_LT((model.predict(c.source.x) - c.source.y).cwiseAbs().mean(), 0.5);
  EXPECT_GT((model.predict(c.target.x).array() - 1.0).abs().maxCoeff(), 0.01);
}

/// The likelihoods of the coregionalised model overflow.
TEST(Transfer, IsFittedWhereItsCorrelationCannotBe) {
  Case c;
  c.target.y *= 1e160;
  const Transfer found = c.by(shift_and_scale);
  EXPECT_TRUE(found.model.predict(c.target.x).allFinite());
  EXPECT_TRUE(std::isnan(found.correlation));
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

/// Changes one column of one table of the file.
void damage(const std::filesystem::path& path, const std::string& group, const std::string& column,
            double value) {
  const auto attributes = table::read_attributes({path, "/"});
  std::vector<std::pair<std::string, table::Table>> tables;
  for (const auto& name : table::list_tables(path)) {
    table::Table t = table::read_table({path, name}), changed;
    for (auto c : t.columns()) {
      if (name == group && c.name == column) c.values = std::vector<double>(t.rows(), value);
      changed.add(c);
    }
    if (!t.columns().empty()) tables.emplace_back(name, changed);
  }
  table::write_tables(path, tables, attributes);
}

TEST(TransferFile, OfImpossibleRelationsIsRefusedByItsName) {
  const auto path = file_of_this_test();
  const Regressor model = Case().by(coregionalised).model;
  const std::vector<std::tuple<const char*, const char*, double>> places{
      {"/part1/relations", "shift_deviation", 0.0}, {"/part1/relations", "noise_variance", 0.0},
      {"/part1/relations", "length_factor2", -1.0}, {"/part1/relations", "weight", 0.9},
      {"/part1/relations", "correlation", 2.0},     {"/parts", "weight", 0.5}};
  for (const auto& [group, column, value] : places) {
    save_regressor(path, {model, {"a", "b"}, "y"});
    damage(path, group, column, value);
    try {
      load_regressor(path);
      ADD_FAILURE() << column;
    } catch (const StorageError& error) {
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
    }
  }
  std::filesystem::remove(path);
}

TEST(TransferFile, KeepsVariancesThatAreNotKnown) {
  const auto path = file_of_this_test();
  Case c(altered, 1);
  c.model = pretrained("linear-svm", c.source, 1);
  const Regressor model = c.by(shift_and_scale).model;
  save_regressor(path, {model, {"a", "b"}, "y"});
  const Regressor loaded = load_regressor(path).model;
  EXPECT_EQ(loaded.predict(c.source.x), model.predict(c.source.x));
  for (const Regressor& m : {model, loaded})
    EXPECT_TRUE(m.predict_with_variances(c.source.x).observation_variance.array().isNaN().all());
  std::filesystem::remove(path);
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

TEST(Joined, CountsRowsWithoutWeightsOnce) {
  TrainingSet a = sampled(bumps, 3, 0.0, 1), b = sampled(bumps, 2, 0.0, 2);
  EXPECT_EQ(joined(a, b).weights.size(), 0);
  b.weights = Vector{{2.0, 3.0}};
  EXPECT_EQ(joined(a, b).weights, (Vector{{1.0, 1.0, 1.0, 2.0, 3.0}}));
  EXPECT_EQ(joined(b, a).weights, (Vector{{2.0, 3.0, 1.0, 1.0, 1.0}}));
}

}  // namespace
}  // namespace repose::surrogate
