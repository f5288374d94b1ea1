#include "task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kPointsForWeights = 4;
constexpr Eigen::Index kMostFolds = 20;
constexpr double kSharpness = 0.1;     // see docs/validation/transfer.md
constexpr double kFarBetter = 0.4;     // of the error of target_only
constexpr double kLeastError = 1e-12;  // of the mean square response

const GaussianProcess& process_for(TransferMethod method, const PretrainedModel& source) {
  const GaussianProcess* process = process_of(source);
  if (process == nullptr)
    throw InputError(
        fmt::format("transfer by {} needs a Gaussian process of the response as "
                    "source; this is {}",
                    to_string(method), source.model.describe()));
  return *process;
}

std::vector<TransferMethod> methods_to_weigh(const PretrainedModel& source) {
  if (process_of(source) != nullptr)
    return {target_only, source_basis, TransferMethod::coregionalised, shift_and_scale, retrained};
  return {target_only, shift_and_scale, retrained};
}

/// Ways that hold on to the source, however unlike the target is, are of use beside those of a
/// process where they predict rows left out far better than these predict each other.
bool may_count(const TransferPart& part, const TransferPart& alone, bool of_process) {
  if (!part.failure.empty()) return false;
  if (!of_process || (part.method != retrained && part.method != shift_and_scale)) return true;
  return part.left_out_rmse < kFarBetter * alone.left_out_rmse;  // false where that is not known
}

/// Weights mse^(-n/10), n points, of those that may count: few rows left out say little of which is
/// best. A mean square error counts as no less than 1e-12 of the mean square response. The first
/// part is target_only.
void weigh(std::vector<TransferPart>& parts, const TrainingSet& target, bool of_process) {
  const double least =
      std::max(kLeastError * target.y.cwiseAbs2().mean(), std::numeric_limits<double>::min());
  const auto error = [least](const TransferPart& part) {
    return std::max(part.left_out_rmse * part.left_out_rmse, least);
  };
  std::vector<TransferPart*> counting, fitted;
  for (TransferPart& part : parts) {
    if (part.failure.empty()) fitted.push_back(&part);
    if (may_count(part, parts.front(), of_process)) counting.push_back(&part);
  }
  if (counting.empty()) counting = fitted;
  double best = std::numeric_limits<double>::infinity(), sum = 0.0;
  for (const TransferPart* part : counting) best = std::min(best, error(*part));
  for (TransferPart* part : counting) {
    part->weight =
        std::pow(error(*part) / best, -kSharpness * static_cast<double>(number_of_points(target)));
    sum += part->weight;
  }
  for (TransferPart* part : counting) part->weight /= sum;
}

/// Of predictions and responses, weighted; NaN below three rows and where one is constant.
double plain_correlation(const Vector& predicted, const TrainingSet& target) {
  const Vector w = target.weights.size() > 0 ? target.weights : Vector(Vector::Ones(target.rows()));
  const Vector a = predicted.array() - w.dot(predicted) / w.sum();
  const Vector b = target.y.array() - w.dot(target.y) / w.sum();
  const double norm = std::sqrt(w.dot(a.cwiseAbs2()) * w.dot(b.cwiseAbs2()));
  return target.rows() > 2 && norm > 0.0 ? w.dot(a.cwiseProduct(b)) / norm : kNaN;
}

/// Throws InputError naming the first input that is not the same.
void check_same_inputs(const std::vector<Input>& source, const std::vector<Input>& target) {
  if (source.size() != target.size())
    throw InputError(fmt::format("the source has {} inputs, the target {}; they must be the same",
                                 source.size(), target.size()));
  for (std::size_t k = 0; k < source.size(); ++k) {
    const Input &a = source[k], &b = target[k];
    const char* differs = nullptr;
    if (a.levels != b.levels)
      differs = "levels";
    else if (a.is_categorical() && a.coding != b.coding)
      differs = "coding";
    else if (!a.is_categorical() && a.scale != b.scale)
      differs = "scale";
    else if (!a.is_categorical() && (a.lower != b.lower || a.upper != b.upper))
      differs = "range";
    if (differs != nullptr)
      throw InputError(fmt::format(
          "input {} of the target has another {} than that of the source; give both the same",
          k + 1, differs));
  }
}

}  // namespace

const GaussianProcess* process_of(const PretrainedModel& source) {
  const GaussianProcess* process = gaussian_process(source.model);
  return process != nullptr && process->response_scale() == ResponseScale::linear ? process
                                                                                  : nullptr;
}

TransferTask::TransferTask(const PretrainedModel& source, const TrainingSet& source_rows,
                           const TrainingSet& target, std::span<const TransferMethod> methods,
                           std::uint64_t seed)
    : source_(source), source_rows_(source_rows), target_(target), seed_(seed) {
  check(source_rows);
  check(target);
  check_same_inputs(source_rows.inputs, target.inputs);
  const Eigen::Index points = number_of_points(target);
  if (points < kPointsForWeights || std::ranges::find(methods, weighted) == methods.end()) return;
  folds_ = k_folds(target, {.folds = static_cast<int>(std::min(points, kMostFolds))});
  fold_of_.resize(static_cast<std::size_t>(target.rows()));
  for (std::size_t f = 0; f < folds_.size(); ++f)
    for (const Eigen::Index i : folds_[f].test)
      fold_of_[static_cast<std::size_t>(i)] = static_cast<Eigen::Index>(f);
}

Transfer TransferTask::by(TransferMethod method) {
  std::vector<TransferPart> parts{{.method = method, .weight = 1.0}};
  TransferredModel model{.source = source_.model};
  if (method == weighted)
    model = combine(parts);
  else
    model.parts.push_back({method, 1.0, fit(method, target_)});
  const Gaussian rho = correlation();
  model.correlation = rho.mean;
  model.correlation_deviation = rho.standard_deviation();
  return {.model = std::move(model),
          .parts = std::move(parts),
          .correlation = rho.mean,
          .correlation_deviation = rho.standard_deviation()};
}

Regressor TransferTask::fit(TransferMethod method, const TrainingSet& target) {
  switch (method) {
    case retrained:
      return source_.again.fit(joined(source_rows_, target), seed_);
    case target_only:
      return target_alone(target);
    case shift_and_scale:
      return ShiftedModel::fit(source_.model, target);
    case source_basis:
      return SourceBasisProcess::fit(process_for(method, source_), target, seed_);
    case TransferMethod::coregionalised:
    case weighted:
      break;  // of several, see combine()
  }
  REPOSE_ASSERT(method == TransferMethod::coregionalised && &target == &target_, to_string(method));
  return coregionalised().process;
}

/// With the source's kernel and hyper-parameters of its own; other models by their settings.
Regressor TransferTask::target_alone(const TrainingSet& target) const {
  const GaussianProcess* process = process_of(source_);
  if (process == nullptr) return source_.again.fit(target, seed_);
  refuse_weights(target);
  return GaussianProcessRegressor(GaussianProcess::fit(
      target.x, target.y, process->inputs(), {.kernel = process->kernel(), .seed = seed_}));
}

const CoregionalisedProcess::Judged& TransferTask::coregionalised() {
  if (!coregionalised_) {
    const GaussianProcess& process = process_for(TransferMethod::coregionalised, source_);
    refuse_weights(target_);
    coregionalised_ =
        CoregionalisedProcess::fit_and_leave_out(process, target_.x, target_.y, fold_of_);
  }
  return *coregionalised_;
}

/// Of the target's rows, those of a fold predicted from the others.
Vector TransferTask::left_out(TransferMethod method) {
  if (method == TransferMethod::coregionalised) return coregionalised().left_out.mean;
  Vector predicted(target_.rows());
  for (const Fold& fold : folds_)
    predicted(fold.test) =
        fit(method, selected_rows(target_, fold.train)).predict(target_.x(fold.test, Eigen::all));
  return predicted;
}

/// Adds the method to the model, without a weight, or says why not.
void TransferTask::judge(TransferPart& part, TransferredModel& model) {
  try {
    Regressor fitted = fit(part.method, target_);
    part.left_out_rmse = metrics_of(target_.y, left_out(part.method), {}, target_.weights).rmse;
    if (!std::isfinite(part.left_out_rmse))
      throw NumericalError("its predictions of rows left out are not finite");
    model.parts.push_back({part.method, 0.0, std::move(fitted)});
  } catch (const Error& error) {
    part.failure = error.what();
  }
}

TransferredModel TransferTask::combine(std::vector<TransferPart>& parts) {
  TransferredModel model{.source = source_.model};
  if (folds_.empty()) {
    parts = {{.method = shift_and_scale, .weight = 1.0}};
    model.parts.push_back({shift_and_scale, 1.0, fit(shift_and_scale, target_)});
    return model;
  }
  if (process_of(source_) != nullptr) refuse_weights(target_);
  parts.clear();
  std::string reasons;
  for (const TransferMethod method : methods_to_weigh(source_)) {
    parts.push_back({.method = method});
    judge(parts.back(), model);
    if (!parts.back().failure.empty())
      reasons += fmt::format("; {}: {}", to_string(method), parts.back().failure);
  }
  if (model.parts.empty()) throw InputError("no way of transfer could be fitted" + reasons);
  weigh(parts, target_, process_of(source_) != nullptr);
  auto next = model.parts.begin();
  for (const TransferPart& part : parts)
    if (part.failure.empty()) (next++)->weight = part.weight;
  std::erase_if(model.parts, [](const auto& part) { return part.weight == 0.0; });
  return model;
}

/// Of the tasks, see Transfer. It is told beside the model: what keeps it from being known does not
/// keep the model from being fitted.
Gaussian TransferTask::correlation() {
  if (correlation_) return *correlation_;
  correlation_ = {kNaN, kNaN};
  if (process_of(source_) == nullptr) {
    correlation_->mean = plain_correlation(source_.model.predict(target_.x), target_);
    return *correlation_;
  }
  try {
    correlation_ = coregionalised().process.correlation();
  } catch (const Error&) {
  }
  return *correlation_;
}

}  // namespace repose::surrogate
