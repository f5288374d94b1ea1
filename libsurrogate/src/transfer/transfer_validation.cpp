#include "repose/surrogate/transfer_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <optional>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "task.hpp"

namespace repose::surrogate {
namespace {

constexpr Metrics kUnknown{};
constexpr double Metrics::*kFigures[] = {&Metrics::rmse, &Metrics::r2,
                                         &Metrics::squared_correlation, &Metrics::mae,
                                         &Metrics::negative_log_density};
constexpr Spread SpreadMetrics::*kSpreads[] = {
    &SpreadMetrics::rmse, &SpreadMetrics::r2, &SpreadMetrics::squared_correlation,
    &SpreadMetrics::mae, &SpreadMetrics::negative_log_density};

/// One method with some rows of one group and one seed.
struct Outcome {
  Metrics validation = kUnknown;
  Metrics unseen = kUnknown;
  double correlation = std::numeric_limits<double>::quiet_NaN();
  bool predicted = false;  ///< the rows not given
  std::string failure;
};

/// Of finite values; a deviation needs two.
Spread spread_of(const std::vector<double>& values) {
  std::vector<double> known;
  for (const double v : values)
    if (std::isfinite(v)) known.push_back(v);
  if (known.empty()) return {};
  const Eigen::Map<const Vector> v(known.data(), static_cast<Eigen::Index>(known.size()));
  Spread spread{.mean = v.mean()};
  if (v.size() > 1)
    spread.deviation =
        std::sqrt((v.array() - v.mean()).square().sum() / static_cast<double>(v.size() - 1));
  return spread;
}

SpreadMetrics spread_of(const std::vector<Metrics>& metrics) {
  SpreadMetrics result;
  for (std::size_t k = 0; k < std::size(kFigures); ++k) {
    std::vector<double> values;
    for (const Metrics& m : metrics) values.push_back(m.*kFigures[k]);
    result.*kSpreads[k] = spread_of(values);
  }
  return result;
}

/// Means of means and of deviations.
Spread average(const std::vector<Spread>& spreads) {
  std::vector<double> means, deviations;
  for (const Spread& s : spreads) {
    means.push_back(s.mean);
    deviations.push_back(s.deviation);
  }
  return {spread_of(means).mean, spread_of(deviations).mean};
}

SpreadMetrics average(const std::vector<SpreadMetrics>& all) {
  SpreadMetrics result;
  for (const auto spread : kSpreads) {
    std::vector<Spread> spreads;
    for (const SpreadMetrics& s : all) spreads.push_back(s.*spread);
    result.*spread = average(spreads);
  }
  return result;
}

/// Throws NumericalError where a fold cannot be fitted.
Metrics cross_validated(const TrainingSet& data, const Trainer& trainer, int folds,
                        std::uint64_t seed) {
  const CrossValidation result =
      cross_validate(data, trainer, k_folds(data, {.folds = folds, .seed = seed}), {.seed = seed});
  for (const FoldResult& fold : result.folds)
    if (!fold.failure.empty())
      throw NumericalError(fmt::format("{} of {} folds; {}: {}", result.failed_folds, folds,
                                       fold.name, fold.failure));
  return result.metrics;
}

/// Adds the validation's figures, or why there are none.
void validate(Outcome& outcome, const TrainingSet& data, const Trainer& trainer, int folds,
              std::uint64_t seed) {
  try {
    outcome.validation = cross_validated(data, trainer, folds, seed);
  } catch (const Error& error) {
    outcome.failure = fmt::format("validation: {}", error.what());
  }
}

Metrics metrics_at(const Regressor& model, const TrainingSet& rows) {
  const Predictions p = model.predict_with_variances(rows.x);
  return metrics_of(rows.y, p.mean, p.observation_variance, rows.weights);
}

std::vector<Eigen::Index> rows_where(const TrainingSet& data, Eigen::Index group, bool equal) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < data.rows(); ++i)
    if ((data.groups[static_cast<std::size_t>(i)] == group) == equal) rows.push_back(i);
  return rows;
}

/// One group as the new one, with one seed: an outcome for each method and number of samples.
class Trial {
 public:
  Trial(const TrainingSet& data, Eigen::Index group, const TransferValidationOptions& options,
        std::uint64_t seed)
      : options_(options),
        seed_(seed),
        source_(with_own_ranges(selected_rows(data, rows_where(data, group, false)),
                                options.undeclared)),
        target_(selected_rows(data, rows_where(data, group, true))) {
    target_.inputs = source_.inputs;
  }

  std::vector<Outcome> run() const {
    std::vector<Outcome> outcomes(options_.methods.size() * options_.samples.size());
    try {
      const PretrainedModel model = pretrained(options_.model, source_, seed_, options_.search);
      const auto order = rows_in_order(model);
      for (std::size_t n = 0; n < options_.samples.size(); ++n) {
        auto of_methods = outcomes_with(model, order, options_.samples[n]);
        for (std::size_t m = 0; m < options_.methods.size(); ++m)
          outcomes[m * options_.samples.size() + n] = std::move(of_methods[m]);
      }
    } catch (const Error& error) {
      for (Outcome& o : outcomes) o.failure = error.what();
    }
    return outcomes;
  }

 private:
  std::vector<Eigen::Index> rows_in_order(const PretrainedModel& model) const {
    if (options_.order == TransferValidationOptions::Order::variance)
      return first_target_runs(model, source_, target_.x, target_.rows());
    std::vector<Eigen::Index> order(static_cast<std::size_t>(target_.rows()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    RandomStream(seed_, 4).shuffle(order);
    return order;
  }

  std::vector<Outcome> outcomes_with(const PretrainedModel& model,
                                     const std::vector<Eigen::Index>& order, int samples) const {
    std::vector<Outcome> results(options_.methods.size());
    if (static_cast<Eigen::Index>(samples) >= target_.rows()) {
      for (Outcome& o : results)
        o.failure = fmt::format("it has {} rows: none are left unseen", target_.rows());
      return results;
    }
    const std::span rows(order);
    const auto given = selected_rows(target_, rows.first(static_cast<std::size_t>(samples)));
    const auto unseen = selected_rows(target_, rows.subspan(static_cast<std::size_t>(samples)));
    std::optional<TransferTask> task;
    if (samples > 0) task.emplace(model, source_, given, options_.methods, seed_);
    for (std::size_t m = 0; m < results.size(); ++m)
      results[m] = outcome(model, task, options_.methods[m], given, unseen);
    return results;
  }

  Outcome outcome(const PretrainedModel& model, std::optional<TransferTask>& task,
                  TransferMethod method, const TrainingSet& given,
                  const TrainingSet& unseen) const {
    Outcome result;
    try {
      const Transfer found = task ? task->by(method) : Transfer{.model = model.model, .parts = {}};
      result.unseen = metrics_at(found.model, unseen);
      result.correlation = found.correlation;
      result.predicted = true;
    } catch (const Error& error) {
      result.failure = error.what();
      return result;
    }
    if (method == TransferMethod::retrained)
      validate(result, task ? joined(source_, given) : source_, model.again, options_.folds, seed_);
    return result;
  }

  const TransferValidationOptions& options_;
  std::uint64_t seed_;
  TrainingSet source_, target_;
};

/// Over seeds.
TransferScore score_of(const std::vector<Outcome>& outcomes) {
  TransferScore score;
  std::vector<Metrics> validation, unseen;
  std::vector<double> correlation;
  for (const Outcome& o : outcomes) {
    validation.push_back(o.validation);
    unseen.push_back(o.unseen);
    correlation.push_back(o.correlation);
    score.averaged += o.predicted ? 1 : 0;
    if (score.failure.empty()) score.failure = o.failure;
  }
  score.validation = spread_of(validation);
  score.unseen = spread_of(unseen);
  score.correlation = spread_of(correlation);
  return score;
}

/// Over groups, of equal samples and method, which may be fewer where rows are few.
TransferScore mean_of(const std::vector<TransferScore>& scores) {
  std::vector<SpreadMetrics> validation, unseen;
  std::vector<Spread> correlation;
  int averaged = 0;
  for (const TransferScore& s : scores) {
    averaged += s.averaged > 0 ? 1 : 0;
    validation.push_back(s.validation);
    unseen.push_back(s.unseen);
    correlation.push_back(s.correlation);
  }
  return {.group = -1,
          .samples = scores.front().samples,
          .method = scores.front().method,
          .validation = average(validation),
          .unseen = average(unseen),
          .correlation = average(correlation),
          .averaged = averaged,
          .failure = averaged == static_cast<int>(scores.size())
                         ? ""
                         : fmt::format("over {} of {} groups; the others have no figures", averaged,
                                       scores.size())};
}

void check(const TrainingSet& data, const TransferValidationOptions& options,
           const std::vector<Eigen::Index>& groups) {
  surrogate::check(data);
  if (groups.size() < 2)
    throw InputError(fmt::format("{} group of rows; transfer needs one to learn from and another",
                                 groups.size()));
  if (options.samples.empty() || options.methods.empty() || options.seeds < 1)
    throw InputError(
        fmt::format("{} numbers of samples, {} methods and {} seeds; there must be at least one of "
                    "each",
                    options.samples.size(), options.methods.size(), options.seeds));
  for (const TransferMethod method : options.methods) check_possible(method, options.model);
  const int fewest = *std::min_element(options.samples.begin(), options.samples.end());
  if (fewest < 0) throw InputError(fmt::format("{} samples; it must be 0 or more", fewest));
  const auto enough = [&](Eigen::Index group) {
    return static_cast<int>(rows_where(data, group, true).size()) > fewest;
  };
  if (std::none_of(groups.begin(), groups.end(), enough))
    throw InputError(
        fmt::format("no group has more than {} rows; none would be left unseen", fewest));
}

}  // namespace

TransferValidation validate_transfer(const TrainingSet& data,
                                     const TransferValidationOptions& options) {
  std::vector<Eigen::Index> groups = data.groups;
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  check(data, options, groups);
  const auto seeds = static_cast<std::size_t>(options.seeds);
  const auto seed_of = [&](std::size_t s) { return derive_seed(options.seed, s); };
  std::vector<std::vector<Outcome>> outcomes(groups.size() * seeds);
  std::vector<Outcome> all_seen(seeds);
  std::mutex mutex;
  double done = 0.0;
  const std::size_t tasks = outcomes.size() + seeds;
  parallel_for(tasks, options.threads, [&](std::size_t task) {
    const std::uint64_t seed = seed_of(task % seeds);
    if (task < outcomes.size()) {
      outcomes[task] = Trial(data, groups[task / seeds], options, seed).run();
    } else {
      const auto model = pretrained(options.model, data, seed, options.search);
      validate(all_seen[task % seeds], data, model.again, options.folds, seed);
    }
    if (!options.progress) return;
    const std::lock_guard lock(mutex);
    options.progress(++done, static_cast<double>(tasks), options.model);
  });

  const TransferScore all = score_of(all_seen);
  TransferValidation result{.all_seen = all.validation, .all_seen_failure = all.failure};
  for (std::size_t m = 0; m < options.methods.size(); ++m) {
    const std::size_t first = result.scores.size(), numbers = options.samples.size();
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (std::size_t n = 0; n < numbers; ++n) {
        std::vector<Outcome> of_seeds;
        for (std::size_t s = 0; s < seeds; ++s)
          of_seeds.push_back(std::move(outcomes[g * seeds + s][m * numbers + n]));
        result.scores.push_back(score_of(of_seeds));
        result.scores.back().group = groups[g];
        result.scores.back().samples = options.samples[n];
        result.scores.back().method = options.methods[m];
      }
    for (std::size_t n = 0; n < numbers; ++n) {
      std::vector<TransferScore> of_groups;
      for (std::size_t g = 0; g < groups.size(); ++g)
        of_groups.push_back(result.scores[first + g * numbers + n]);
      result.means.push_back(mean_of(of_groups));
    }
  }
  return result;
}

}  // namespace repose::surrogate
