#include "repose/surrogate/cross_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void check_folds(const std::vector<Fold>& folds, Eigen::Index rows) {
  if (folds.empty()) throw InputError("a cross-validation without folds");
  for (const Fold& fold : folds) {
    if (fold.train.empty() || fold.test.empty())
      throw InputError(fmt::format("{} has {} rows to fit to and {} to predict; both are needed",
                                   fold.name, fold.train.size(), fold.test.size()));
    for (const auto* indices : {&fold.train, &fold.test})
      for (const Eigen::Index i : *indices)
        if (i < 0 || i >= rows)
          throw InputError(fmt::format("{} names row {}; there are {}", fold.name, i + 1, rows));
    if (fold.repetition < 0)
      throw InputError(fmt::format("{} is of repetition {}", fold.name, fold.repetition));
  }
}

/// Levels that test rows have and training rows lack, and a training response without variation.
std::string note_on(const TrainingSet& train, const TrainingSet& test) {
  std::string note;
  const auto add = [&note](const std::string& sentence) {
    note += (note.empty() ? "" : "; ") + sentence;
  };
  if (train.y.maxCoeff() == train.y.minCoeff())
    add(fmt::format("the response is {} in all training rows", train.y[0]));
  for (std::size_t k = 0; k < test.inputs.size(); ++k) {
    if (!test.inputs[k].is_categorical()) continue;
    const auto column = static_cast<Eigen::Index>(k);
    const Vector seen = train.x.col(column), asked = test.x.col(column);
    const std::set<double> known(seen.begin(), seen.end());
    for (const double level : std::set<double>(asked.begin(), asked.end()))
      if (!known.contains(level))
        add(fmt::format("no training row has level '{}' of input {}",
                        test.inputs[k].levels[static_cast<std::size_t>(level)], k + 1));
  }
  return note;
}

/// Fits to one fold and predicts it; what it predicts goes into the rows of `all`.
FoldResult run(const TrainingSet& data, const Trainer& trainer, const Fold& fold,
               std::uint64_t seed, Predictions& predictions) {
  FoldResult result{.name = fold.name, .repetition = fold.repetition};
  const TrainingSet train = selected_rows(data, fold.train);
  const TrainingSet test = selected_rows(data, fold.test);
  result.note = note_on(train, test);
  try {
    Clock::time_point start = Clock::now();
    const Regressor model = trainer.fit(train, seed);
    result.training_seconds = seconds_since(start);
    result.description = model.describe();
    start = Clock::now();
    predictions = model.predict_with_variances(test.x);
    result.prediction_seconds = seconds_since(start);
    if (!predictions.mean.allFinite()) throw NumericalError("a prediction is not finite");
    result.metrics =
        metrics_of(test.y, predictions.mean, predictions.observation_variance, test.weights);
  } catch (const Error& error) {
    result.failure = error.what();
  }
  return result;
}

/// Of all rows and repetitions that have a prediction.
Metrics pooled_metrics(const TrainingSet& data, const CrossValidation& result) {
  std::vector<double> y, p, v, w;
  for (Eigen::Index r = 0; r < result.predicted.cols(); ++r)
    for (Eigen::Index i = 0; i < data.rows(); ++i)
      if (!std::isnan(result.predicted(i, r))) {
        y.push_back(data.y[i]);
        p.push_back(result.predicted(i, r));
        v.push_back(result.variance(i, r));
        if (data.weights.size() > 0) w.push_back(data.weights[i]);
      }
  const auto vector = [](const std::vector<double>& values) {
    return Vector(
        Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  return metrics_of(vector(y), vector(p), vector(v), vector(w));
}

CrossValidation empty_result(const TrainingSet& data, const std::vector<Fold>& folds) {
  int repetitions = 1;
  for (const Fold& fold : folds) repetitions = std::max(repetitions, fold.repetition + 1);
  return {.folds = std::vector<FoldResult>(folds.size()),
          .predicted = Matrix::Constant(data.rows(), repetitions, kNaN),
          .variance = Matrix::Constant(data.rows(), repetitions, kNaN)};
}

void store(const Fold& fold, const Predictions& predictions, CrossValidation& result) {
  for (std::size_t i = 0; i < fold.test.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    result.predicted(fold.test[i], fold.repetition) = predictions.mean[row];
    if (predictions.observation_variance.size() > 0)
      result.variance(fold.test[i], fold.repetition) = predictions.observation_variance[row];
  }
}

}  // namespace

std::vector<CrossValidation> cross_validate(const TrainingSet& data,
                                            const std::vector<Trainer>& trainers,
                                            const std::vector<Fold>& folds,
                                            const CrossValidationOptions& options) {
  check(data);
  check_folds(folds, data.rows());
  const std::size_t tasks = trainers.size() * folds.size();
  std::vector<CrossValidation> results(trainers.size(), empty_result(data, folds));
  std::vector<Predictions> predictions(tasks);
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(tasks, options.threads, [&](std::size_t task) {
    const std::size_t t = task / folds.size(), f = task % folds.size();
    FoldResult& result = results[t].folds[f];
    result = run(data, trainers[t], folds[f], derive_seed(options.seed, f), predictions[task]);
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress)
      options.progress(static_cast<double>(done), static_cast<double>(tasks),
                       fmt::format("{}, {}{}", trainers[t].name, folds[f].name,
                                   result.failure.empty() ? "" : ": failed"));
  });
  for (std::size_t task = 0; task < tasks; ++task) {
    CrossValidation& result = results[task / folds.size()];
    const std::size_t f = task % folds.size();
    if (result.folds[f].failure.empty())
      store(folds[f], predictions[task], result);
    else
      ++result.failed_folds;
  }
  for (CrossValidation& result : results) result.metrics = pooled_metrics(data, result);
  return results;
}

CrossValidation cross_validate(const TrainingSet& data, const Trainer& trainer,
                               const std::vector<Fold>& folds,
                               const CrossValidationOptions& options) {
  return cross_validate(data, std::vector{trainer}, folds, options).front();
}

CrossValidation cross_validate_fixed(const TrainingSet& data, const Regressor& gaussian_process,
                                     const std::vector<Fold>& folds) {
  check(data);
  check_folds(folds, data.rows());
  const GaussianProcess* model = surrogate::gaussian_process(gaussian_process);
  if (model == nullptr || model->rows() != data.rows())
    throw InputError(fmt::format(
        "{}: cross-validation in closed form is for a Gaussian process of the same {} rows; fit "
        "each fold instead",
        gaussian_process.describe(), data.rows()));
  CrossValidation result = empty_result(data, folds);
  for (int r = 0; r < result.predicted.cols(); ++r) {
    std::vector<Eigen::Index> fold_of_row(static_cast<std::size_t>(data.rows()), -1);
    for (std::size_t f = 0; f < folds.size(); ++f)
      for (const Eigen::Index i : folds[f].test) {
        if (folds[f].repetition != r) continue;
        auto& fold = fold_of_row[static_cast<std::size_t>(i)];
        if (fold >= 0)
          throw InputError(
              fmt::format("row {} is in {} and in another fold", i + 1, folds[f].name));
        fold = static_cast<Eigen::Index>(f);
      }
    const auto missing = std::find(fold_of_row.begin(), fold_of_row.end(), -1);
    if (missing != fold_of_row.end())
      throw InputError(
          fmt::format("row {} is in no fold; folds in closed form must divide all rows",
                      missing - fold_of_row.begin() + 1));
    const LeftOut out = model->leave_groups_out(fold_of_row);
    result.predicted.col(r) = out.predicted;
    result.variance.col(r) = out.variance;
  }
  for (std::size_t f = 0; f < folds.size(); ++f) {
    FoldResult& fold = result.folds[f];
    fold = {.name = folds[f].name, .repetition = folds[f].repetition};
    fold.description = gaussian_process.describe();
    const auto& test = folds[f].test;
    const Vector predicted = result.predicted(test, fold.repetition);
    if (predicted.allFinite()) {
      fold.metrics =
          metrics_of(data.y(test), predicted, Vector(result.variance(test, fold.repetition)),
                     data.weights.size() > 0 ? Vector(data.weights(test)) : Vector());
    } else {
      fold.failure = "its rows alone determine a coefficient of the trend";
      ++result.failed_folds;
    }
  }
  result.metrics = pooled_metrics(data, result);
  return result;
}

TrainingSet with_own_ranges(TrainingSet data, const std::vector<bool>& undeclared) {
  for (std::size_t k = 0; k < data.inputs.size() && k < undeclared.size(); ++k) {
    Input& input = data.inputs[k];
    if (!undeclared[k] || input.is_categorical()) continue;
    const auto column = data.x.col(static_cast<Eigen::Index>(k));
    if (!(column.minCoeff() < column.maxCoeff())) continue;
    input.lower = column.minCoeff();
    input.upper = column.maxCoeff();
  }
  return data;
}

Trainer with_ranges_of_training_rows(Trainer trainer, std::vector<bool> undeclared) {
  const std::string name = trainer.name;
  return {.name = name,
          .fit = [inner = std::move(trainer.fit), undeclared = std::move(undeclared)](
                     const TrainingSet& data, std::uint64_t seed) {
            return inner(with_own_ranges(data, undeclared), seed);
          }};
}

double prediction_rate(const Regressor& model, const Matrix& x) {
  constexpr double kSeconds = 0.05;
  const Clock::time_point start = Clock::now();
  double rows = 0.0;
  do {
    model.predict(x);
    rows += static_cast<double>(x.rows());
  } while (seconds_since(start) < kSeconds);
  return rows / seconds_since(start);
}

}  // namespace repose::surrogate
