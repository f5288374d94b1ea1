#include "acquirer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/acquisition.hpp"
#include "soft_improvement.hpp"

namespace repose::opt {
namespace {

/// Visited points that are drawn jointly; the others are too bad to be the best.
constexpr Eigen::Index kJointPoints = 32;

}  // namespace

Matrix promising_rows(const Matrix& points, const std::vector<Predictions>& predicted,
                      const Goal& goal, Eigen::Index count) {
  std::vector<double> bound, mean;
  for (const Predictions& p : predicted) {
    const Gaussian objective = goal.objective(std::span<const Gaussian>(p));
    bound.push_back(lower_confidence_bound(objective, 2.0));
    mean.push_back(objective.mean);
  }
  if (mean.empty()) return points;
  std::vector<Eigen::Index> order = ascending(bound);
  const auto incumbent = std::find(order.begin(), order.end(), ascending(mean).front());
  std::rotate(order.begin(), incumbent, incumbent + 1);  // known best, if not what may be
  std::vector<Eigen::Index> chosen;
  for (const Eigen::Index i : order) {
    if (static_cast<Eigen::Index>(chosen.size()) == count) break;
    const bool repeated = std::any_of(chosen.begin(), chosen.end(), [&](Eigen::Index c) {
      return points.row(c) == points.row(i);
    });
    if (!repeated) chosen.push_back(i);
  }
  return points(chosen, Eigen::all);
}

Acquirer::Acquirer(const BelievedModels& models, const Goal& goal, const ProposeOptions& options,
                   std::uint64_t seed)
    : models_(models), goal_(goal), options_(options) {
  // the same draws for every point of a batch, so that merits within it compare
  if (goal.is_composite())
    normals_ = scrambled_normals(options.draws, static_cast<Eigen::Index>(models.models().size()),
                                 options.seed);
  if (models.incumbents().rows() == 0) return;
  const std::vector<Predictions> predicted = models.predict_rows(models.incumbents());
  for (const Predictions& p : predicted)
    incumbent_means_.push_back(goal.objective(std::span<const Gaussian>(p)).mean);
  best_ = incumbent_means_[static_cast<std::size_t>(ascending(incumbent_means_).front())];
  if (options.acquisition != Acquisition::noisy_expected_improvement) return;
  visited_.emplace(models.models(),
                   promising_rows(models.incumbents(), predicted, goal, kJointPoints),
                   options.draws, derive_seed(seed, 2));
  best_of_draw_ = visited_->objective(goal).colwise().minCoeff().transpose();
}

void Acquirer::beat_the_best_of(const std::vector<Predictions>& predicted) {
  for (const Predictions& p : predicted)
    best_ = std::min(best_, goal_.objective(std::span<const Gaussian>(p)).mean);
}

std::vector<JointDraws::Conditional> Acquirer::given(const Matrix& points) const {
  std::vector<JointDraws::Conditional> all;
  for (std::size_t j = 0; j < models_.models().size(); ++j)
    all.push_back(visited_->given(j, points));
  return all;
}

double Acquirer::noisy_log_improvement(const Gaussian& predicted,
                                       const JointDraws::Conditional& given, Eigen::Index p) const {
  const double variance = std::max(0.0, predicted.variance - given.explained[p]);
  Vector logs(best_of_draw_.size());
  for (Eigen::Index m = 0; m < logs.size(); ++m)
    logs[m] =
        log_expected_improvement({predicted.mean + given.shift(p, m), variance}, best_of_draw_[m]);
  const double largest = logs.maxCoeff();
  if (!std::isfinite(largest)) return largest;
  return largest + std::log((logs.array() - largest).exp().mean());
}

double Acquirer::noisy_value(const Predictions& predicted,
                             const std::vector<JointDraws::Conditional>& given,
                             Eigen::Index p) const {
  if (!goal_.is_composite()) return noisy_log_improvement(predicted[0], given[0], p);
  std::vector<double> deviation;
  for (std::size_t j = 0; j < predicted.size(); ++j)
    deviation.push_back(std::sqrt(std::max(0.0, predicted[j].variance - given[j].explained[p])));
  std::vector<double> h(predicted.size());
  double sum = 0.0;
  for (Eigen::Index m = 0; m < best_of_draw_.size(); ++m) {
    for (std::size_t j = 0; j < h.size(); ++j)
      h[j] = predicted[j].mean + given[j].shift(p, m) +
             deviation[j] * normals_(m, static_cast<Eigen::Index>(j));
    sum += soft_improvement(best_of_draw_[m] - goal_.objective(std::span<const double>(h)), best_);
  }
  return std::log(sum / static_cast<double>(best_of_draw_.size()));
}

std::vector<double> Acquirer::values(const Matrix& points,
                                     const std::vector<Predictions>& predicted) const {
  std::vector<double> result(predicted.size());
  if (visited_) {
    const auto conditional = given(points);
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = noisy_value(predicted[i], conditional, static_cast<Eigen::Index>(i));
    return result;
  }
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = options_.acquisition == Acquisition::lower_confidence_bound
                    ? -lower_confidence_bound(
                          goal_.objective(std::span<const Gaussian>(predicted[i])), options_.kappa)
                    : goal_.log_improvement(predicted[i], best_, normals_);
  return result;
}

double Acquirer::value(const Vector& x) const {
  return values(x.transpose(), {models_.predict(x)})[0];
}

bool Acquirer::has_gradient() const {
  const auto models = models_.models();
  return options_.acquisition == Acquisition::expected_improvement &&
         std::all_of(models.begin(), models.end(),
                     [](const Surrogate& model) { return model.has_gradient(); });
}

double Acquirer::value(const Vector& x, Vector& gradient) const {
  Predictions predicted;
  std::vector<PredictionGradient> gradients;
  for (const Surrogate& model : models_.models()) {
    gradients.push_back(model.predict_gradient(x));
    predicted.push_back(gradients.back().function);
  }
  const CompositeGradient by = goal_.log_improvement_gradient(predicted, best_, normals_);
  gradient.setZero(x.size());
  for (std::size_t j = 0; j < gradients.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    gradient += by.by_mean[column] * gradients[j].mean +
                by.by_standard_deviation[column] * gradients[j].standard_deviation;
  }
  return by.value;
}

}  // namespace repose::opt
