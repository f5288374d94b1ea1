#include "repose/surrogate/transfer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "parts.hpp"
#include "prior_covariance.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/coregionalised_process.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;

constexpr std::array kMethods{retrained,    target_only,    shift_and_scale,
                              source_basis, coregionalised, weighted};
constexpr Eigen::Index kRowsForWeights = 4;
constexpr int kLargestFolds = 20;
constexpr double kSharpness = 0.1;  // see docs/validation/transfer.md

/// The process of a source that the closed forms can use, else nullptr.
const GaussianProcess* process_of(const PretrainedModel& source) {
  const GaussianProcess* process = gaussian_process(source.model);
  return process != nullptr && process->response_scale() == ResponseScale::linear ? process
                                                                                  : nullptr;
}

const GaussianProcess& process_for(TransferMethod method, const PretrainedModel& source) {
  const GaussianProcess* process = process_of(source);
  if (process == nullptr)
    throw InputError(
        fmt::format("transfer by {} needs a Gaussian process of the response as "
                    "source; this is {}",
                    to_string(method), source.model.describe()));
  return *process;
}

class Task {
 public:
  Task(const PretrainedModel& source, const TrainingSet& source_rows, std::uint64_t seed)
      : source_(source), source_rows_(source_rows), seed_(seed) {}

  Regressor fit(TransferMethod method, const TrainingSet& target) const {
    switch (method) {
      case retrained:
        return source_.again.fit(joined(source_rows_, target), seed_);
      case target_only:
        return target_alone(target);
      case shift_and_scale:
        return ShiftedModel::fit(source_.model, target.x, target.y);
      case source_basis:
        return SourceBasisProcess::fit(process_for(method, source_), target.x, target.y, seed_);
      case coregionalised:
      case weighted:
        break;  // of several, see combine()
    }
    REPOSE_ASSERT(method == coregionalised, to_string(method));
    return CoregionalisedProcess::fit(process_for(method, source_), target.x, target.y);
  }

  /// NaN where nothing is left to fit to.
  Vector left_out(TransferMethod method, const Regressor& fitted, const TrainingSet& target,
                  const std::vector<Fold>& folds) const {
    Vector predicted(target.rows());
    if (const auto* process = fitted.target<CoregionalisedProcess>()) {
      std::vector<Eigen::Index> groups(static_cast<std::size_t>(target.rows()));
      for (std::size_t f = 0; f < folds.size(); ++f)
        for (const Eigen::Index i : folds[f].test)
          groups[static_cast<std::size_t>(i)] = static_cast<Eigen::Index>(f);
      return process->leave_groups_out(groups).mean;
    }
    for (const Fold& fold : folds)
      predicted(fold.test) =
          fit(method, selected_rows(target, fold.train)).predict(target.x(fold.test, Eigen::all));
    return predicted;
  }

 private:
  /// With the source's kernel and hyper-parameters of its own; other models by their settings.
  Regressor target_alone(const TrainingSet& target) const {
    const GaussianProcess* process = process_of(source_);
    if (process == nullptr) return source_.again.fit(target, seed_);
    return GaussianProcessRegressor(GaussianProcess::fit(
        target.x, target.y, process->inputs(), {.kernel = process->kernel(), .seed = seed_}));
  }

  const PretrainedModel& source_;
  const TrainingSet& source_rows_;
  std::uint64_t seed_;
};

std::vector<TransferMethod> methods_to_weigh(const PretrainedModel& source) {
  if (process_of(source) != nullptr) return {target_only, source_basis, coregionalised};
  return {retrained, target_only, shift_and_scale};
}

/// Weights mse^(-n/10) of those that did not fail: few rows left out say little of which is best. A
/// mean square error counts as no less than 1e-12 of the responses'.
void weigh(std::vector<TransferPart>& parts, const Vector& y) {
  const double least = 1e-12 * (y.array() - y.mean()).square().mean();
  double sum = 0.0, best = std::numeric_limits<double>::infinity();
  const auto error = [least](const TransferPart& part) {
    return std::max(part.left_out_rmse * part.left_out_rmse, least);
  };
  for (const TransferPart& part : parts)
    if (part.failure.empty()) best = std::min(best, error(part));
  for (TransferPart& part : parts) {
    if (!part.failure.empty()) continue;
    const double ratio = best > 0.0 ? error(part) / best : 1.0;
    part.weight = std::pow(ratio, -kSharpness * static_cast<double>(y.size()));
    sum += part.weight;
  }
  for (TransferPart& part : parts) part.weight /= sum;
}

Eigen::Index number_of(const std::vector<Eigen::Index>& points) {
  return points.empty() ? 0 : *std::max_element(points.begin(), points.end()) + 1;
}

TransferredModel combine(const Task& task, const PretrainedModel& source, const TrainingSet& target,
                         std::vector<TransferPart>& parts) {
  const Eigen::Index points = number_of(points_of(target));
  TransferredModel model{.source = source.model};
  if (points < kRowsForWeights) {
    parts = {{.method = shift_and_scale, .weight = 1.0}};
    model.parts.push_back({shift_and_scale, 1.0, task.fit(shift_and_scale, target)});
    return model;
  }
  const auto folds =
      k_folds(target, {.folds = static_cast<int>(std::min<Eigen::Index>(points, kLargestFolds))});
  std::string reasons;
  for (const TransferMethod method : methods_to_weigh(source)) {
    TransferPart part{.method = method};
    try {
      Regressor fitted = task.fit(method, target);
      const Vector predicted = task.left_out(method, fitted, target, folds);
      part.left_out_rmse = metrics_of(target.y, predicted, {}, target.weights).rmse;
      if (!std::isfinite(part.left_out_rmse))
        throw NumericalError("its predictions are not finite");
      model.parts.push_back({method, 0.0, std::move(fitted)});
    } catch (const Error& error) {
      part.failure = error.what();
      reasons += fmt::format("; {}: {}", to_string(method), part.failure);
    }
    parts.push_back(std::move(part));
  }
  if (model.parts.empty()) throw InputError("no way of transfer could be fitted" + reasons);
  weigh(parts, target.y);
  auto next = model.parts.begin();
  for (const TransferPart& part : parts)
    if (part.failure.empty()) (next++)->weight = part.weight;
  return model;
}

/// Of the tasks, see Transfer; from a part of the model if it has one that knows.
void find_correlation(const PretrainedModel& source, const TrainingSet& target,
                      const TransferredModel& model, Transfer& result) {
  if (const GaussianProcess* process = process_of(source)) {
    const CoregionalisedProcess* fitted = nullptr;
    for (const auto& part : model.parts)
      if (const auto* found = part.model.target<CoregionalisedProcess>()) fitted = found;
    const Gaussian rho =
        fitted != nullptr ? fitted->correlation()
                          : CoregionalisedProcess::fit(*process, target.x, target.y).correlation();
    result.correlation = rho.mean;
    result.correlation_deviation = rho.standard_deviation();
    return;
  }
  const Vector p = source.model.predict(target.x);
  const Vector a = p.array() - p.mean(), b = target.y.array() - target.y.mean();
  const double norm = a.norm() * b.norm();
  if (target.rows() > 2 && norm > 0.0) result.correlation = a.dot(b) / norm;
}

bool same_inputs(const std::vector<Input>& a, const std::vector<Input>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k].levels != b[k].levels || a[k].scale != b[k].scale) return false;
  return true;
}

}  // namespace

const char* to_string(TransferMethod method) {
  switch (method) {
    case retrained:
      return "retrained";
    case target_only:
      return "target-only";
    case shift_and_scale:
      return "shift-and-scale";
    case source_basis:
      return "source-basis";
    case coregionalised:
      return "coregionalised";
    case weighted:
      return "weighted";
  }
  return "?";
}

TransferMethod transfer_method_named(std::string_view name) {
  std::vector<std::string> names;
  for (const TransferMethod method : kMethods) {
    if (name == to_string(method)) return method;
    names.emplace_back(to_string(method));
  }
  throw InputError(
      fmt::format("there is no way of transfer '{}'; choose {}", name, fmt::join(names, ", ")));
}

Transfer transfer(const PretrainedModel& source, const TrainingSet& source_rows,
                  const TrainingSet& target, const TransferOptions& options) {
  if (target.rows() == 0) return {.model = source.model, .parts = {}};
  check(source_rows);
  check(target);
  if (!same_inputs(source_rows.inputs, target.inputs))
    throw InputError("source and target have different inputs; they must be the same columns");
  const Task task(source, source_rows, options.seed);
  std::vector<TransferPart> parts;
  TransferredModel model{.source = source.model};
  if (options.method == weighted) {
    model = combine(task, source, target, parts);
  } else {
    parts = {{.method = options.method, .weight = 1.0}};
    model.parts.push_back({options.method, 1.0, task.fit(options.method, target)});
  }
  Transfer result{.model = source.model, .parts = std::move(parts)};
  find_correlation(source, target, model, result);
  model.correlation = result.correlation;
  model.correlation_deviation = result.correlation_deviation;
  result.model = std::move(model);
  return result;
}

TrainingSet joined(const TrainingSet& a, const TrainingSet& b) {
  const Eigen::Index n = a.rows(), m = b.rows();
  TrainingSet both{.x = Matrix(n + m, a.x.cols()), .y = Vector(n + m), .inputs = a.inputs};
  both.x << a.x, b.x;
  both.y << a.y, b.y;
  if (a.weights.size() > 0 && b.weights.size() > 0) {
    both.weights.resize(n + m);
    both.weights << a.weights, b.weights;
  }
  if (!a.groups.empty() && !b.groups.empty()) {
    both.groups = a.groups;
    both.groups.insert(both.groups.end(), b.groups.begin(), b.groups.end());
  }
  both.replicates = points_of(a);
  const Eigen::Index known = number_of(both.replicates);
  for (const Eigen::Index p : points_of(b)) both.replicates.push_back(known + p);
  return both;
}

/// Greedy: row i takes away sum_j C_ij^2/(C_ii + noise) of the candidates' variances.
std::vector<Eigen::Index> first_target_runs(const GaussianProcess& source, const Matrix& candidates,
                                            Eigen::Index count, const Matrix& simulated) {
  const Eigen::Index m = candidates.rows(), p = simulated.rows();
  if (count < 0 || count > m)
    throw InputError(
        fmt::format("{} runs to choose from {} candidates; ask for no more than there "
                    "are",
                    count, m));
  Matrix all(p + m, candidates.cols());
  if (p > 0) all.topRows(p) = simulated;
  all.bottomRows(m) = candidates;
  Matrix c = prior_target_covariance(source, all);
  const double noise = std::max(source.noise_variance(), 1e-9 * c.diagonal().maxCoeff());
  const auto observe = [&](Eigen::Index i) {
    const Vector column = c.col(i);
    c -= column * column.transpose() / (column[i] + noise);
  };
  for (Eigen::Index i = 0; i < p; ++i) observe(i);
  std::vector<Eigen::Index> chosen;
  std::vector<bool> taken(static_cast<std::size_t>(m), false);
  while (static_cast<Eigen::Index>(chosen.size()) < count) {
    Eigen::Index best = -1;
    double most = -1.0;
    for (Eigen::Index i = 0; i < m; ++i) {
      if (taken[static_cast<std::size_t>(i)]) continue;
      const double gain =
          c.col(p + i).tail(m).squaredNorm() / (std::max(0.0, c(p + i, p + i)) + noise);
      if (gain > most) {
        most = gain;
        best = i;
      }
    }
    taken[static_cast<std::size_t>(best)] = true;
    chosen.push_back(best);
    observe(p + best);
  }
  return chosen;
}

std::vector<Eigen::Index> first_target_runs(const PretrainedModel& source,
                                            const TrainingSet& source_rows,
                                            const Matrix& candidates, Eigen::Index count,
                                            const Matrix& simulated) {
  const GaussianProcess* process = gaussian_process(source.model);
  return first_target_runs(
      process != nullptr ? *process
                         : GaussianProcess::fit(source_rows.x, source_rows.y, source_rows.inputs),
      candidates, count, simulated);
}

}  // namespace repose::surrogate
