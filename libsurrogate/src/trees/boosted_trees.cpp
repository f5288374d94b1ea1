#include "repose/surrogate/boosted_trees.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "growing.hpp"
#include "repose/base/error.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "states.hpp"

namespace repose::surrogate {
namespace {

using trees::Count;
using trees::Forest;

struct Boosting {
  double constant = 0.0;
  Forest forest = {};
};

double weighted_mean(const Vector& y, const std::vector<double>& weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    sum += weights[i] * y[static_cast<Eigen::Index>(i)];
  return sum / std::accumulate(weights.begin(), weights.end(), 0.0);
}

template <class G>
Boosting boost(const TrainingSet& data, const BoostedTreesOptions& options, std::uint64_t seed) {
  const trees::Columns columns(data.x, data.inputs);
  G grower(columns, trees::limits_of(options.tree, columns));
  const std::vector<double> weights = trees::weights_of(data);
  const std::vector<Count> once(weights.size(), 1);
  Boosting result{.constant = weighted_mean(data.y, weights)};  // Eq. 4.2
  std::vector<double> f(weights.size(), result.constant);
  std::vector<double> residual(weights.size());
  for (Eigen::Index m = 0; m < options.trees; ++m) {
    for (std::size_t i = 0; i < f.size(); ++i)
      residual[i] = data.y[static_cast<Eigen::Index>(i)] - f[i];  // Eq. 4.3
    RandomStream random(seed, static_cast<std::uint64_t>(m));
    grower.grow(residual, weights, once, random);  // Eq. 4.4
    if (!grower.has_split()) break;
    grower.for_each_leaf([&](std::span<const Count> rows, double mean) {
      for (const Count i : rows) f[i] += options.learning_rate * mean;  // Eq. 4.5
    });
    result.forest.append(grower.forest());
  }
  return result;
}

Boosting boost(const TrainingSet& data, const BoostedTreesOptions& options, std::uint64_t seed) {
  return trees::with_sums_of(data, [&]<class G>(G*) { return boost<G>(data, options, seed); });
}

/// Weighted squared errors at `test` with 0, 1, ... trees fitted to `train`, added to `squares`.
Vector squares_by_trees(const TrainingSet& train, const TrainingSet& test,
                        const BoostedTreesOptions& options, std::uint64_t seed) {
  const Boosting model = boost(train, options, seed);
  Vector f = Vector::Constant(test.rows(), model.constant);
  const std::vector<double> w = trees::weights_of(test);
  const Eigen::Map<const Vector> weights(w.data(), test.rows());
  Vector squares(options.trees + 1);
  const Matrix steps = options.learning_rate * trees::predictions_of_trees(model.forest, test.x);
  for (Eigen::Index m = 0; m <= options.trees; ++m) {  // after its end nothing changes
    if (m > 0 && m <= steps.rows()) f += steps.row(m - 1).transpose();
    squares[m] = weights.dot((test.y - f).cwiseAbs2());
  }
  return squares;
}

std::vector<double> held_out_curve(const TrainingSet& data, const BoostedTreesOptions& options) {
  std::vector<Fold> folds = k_folds(
      data, {.folds = static_cast<int>(options.folds), .seed = derive_seed(options.seed, 0)});
  if (options.stopping == Stopping::held_out) folds.resize(1);
  std::vector<Vector> squares(folds.size());
  std::vector<double> weight(folds.size());
  parallel_for(folds.size(), options.threads, [&](std::size_t f) {
    const TrainingSet test = selected_rows(data, folds[f].test);
    const std::uint64_t seed = derive_seed(options.seed, f + 1);
    squares[f] = squares_by_trees(selected_rows(data, folds[f].train), test, options, seed);
    weight[f] = test.weights.size() > 0 ? test.weights.sum() : static_cast<double>(test.rows());
  });
  const double all = std::accumulate(weight.begin(), weight.end(), 0.0);
  std::vector<double> rmse;
  for (Eigen::Index m = 0; m <= options.trees; ++m) {
    double sum = 0.0;
    for (const Vector& fold : squares) sum += fold[m];
    rmse.push_back(std::sqrt(sum / all));
  }
  return rmse;
}

void check_options(const BoostedTreesOptions& options, Eigen::Index inputs) {
  trees::check_options(options.tree, inputs);
  if (options.trees < 1)
    throw InputError(fmt::format("{} trees to boost; there must be at least 1", options.trees));
  if (!(options.learning_rate > 0.0 && options.learning_rate <= 1.0))
    throw InputError(fmt::format("the learning rate is {}; it must be above 0 and at most 1",
                                 options.learning_rate));
  if (options.folds < 2)
    throw InputError(fmt::format("{} folds; there must be at least 2", options.folds));
}

}  // namespace

const char* to_string(Stopping stopping) {
  constexpr const char* kNames[] = {"none", "held-out", "k-fold"};
  return kNames[static_cast<std::size_t>(stopping)];
}

BoostedTrees BoostedTrees::fit(const TrainingSet& data, const BoostedTreesOptions& given) {
  check(data);
  check_options(given, data.dimension());
  State state{.inputs = data.inputs, .options = given};
  BoostedTreesOptions final_options = given;
  if (given.stopping != Stopping::none) {
    state.held_out_rmse = held_out_curve(data, given);
    const auto best = std::min_element(state.held_out_rmse.begin(), state.held_out_rmse.end());
    final_options.trees = best - state.held_out_rmse.begin();
  }
  Boosting boosting = boost(data, final_options, given.seed);
  state.constant = boosting.constant;
  state.forest = std::move(boosting.forest);
  return TreeAccess::make<BoostedTrees>(std::move(state));
}

Vector BoostedTrees::predict(const Matrix& x) const {
  check_points(state_->inputs, x);
  Vector f = Vector::Constant(x.rows(), state_->constant);
  trees::add_predictions(state_->forest, x, state_->options.learning_rate, f);
  return f;
}

const std::vector<Input>& BoostedTrees::inputs() const {
  return state_->inputs;
}

std::string BoostedTrees::describe() const {
  return fmt::format(
      "{} boosted trees, learning rate {:.4g}{}", trees(), state_->options.learning_rate,
      trees::describe(state_->options.tree, static_cast<Eigen::Index>(inputs().size())));
}

const BoostedTreesOptions& BoostedTrees::options() const {
  return state_->options;
}

Eigen::Index BoostedTrees::trees() const {
  return static_cast<Eigen::Index>(state_->forest.trees.size());
}

double BoostedTrees::constant() const {
  return state_->constant;
}

const std::vector<double>& BoostedTrees::held_out_rmse() const {
  return state_->held_out_rmse;
}

Trainer boosted_trees_trainer(std::string name, const BoostedTreesOptions& options) {
  return {std::move(name), [options](const TrainingSet& data, std::uint64_t seed) -> Regressor {
            BoostedTreesOptions o = options;
            o.seed = seed;
            return BoostedTrees::fit(data, o);
          }};
}

}  // namespace repose::surrogate
