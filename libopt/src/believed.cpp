#include "believed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "repose/base/thread_pool.hpp"

namespace repose::opt {
namespace {

/// What the constant liar says of every model, from the predictions at the visited points.
std::vector<double> lie_of(const std::vector<Predictions>& visited, const Goal& goal,
                           Belief belief) {
  if (belief == Belief::kriging || visited.empty()) return {};
  std::vector<double> lie(visited[0].size(), 0.0);
  if (belief == Belief::mean_lie) {
    for (const Predictions& p : visited)
      for (std::size_t j = 0; j < lie.size(); ++j)
        lie[j] += p[j].mean / static_cast<double>(visited.size());
    return lie;
  }
  const auto smaller = [&goal](const Predictions& a, const Predictions& b) {
    return goal.objective(a).mean < goal.objective(b).mean;
  };
  const Predictions& p = belief == Belief::best_lie
                             ? *std::min_element(visited.begin(), visited.end(), smaller)
                             : *std::max_element(visited.begin(), visited.end(), smaller);
  for (std::size_t j = 0; j < lie.size(); ++j) lie[j] = p[j].mean;
  return lie;
}

}  // namespace

bool belongs_to(const FeasibleSet& set, const Vector& x) {
  constexpr double kRounding = 1e-9;
  if (violation(x, set) > kRounding) return false;
  const Vector range = (set.bounds.upper - set.bounds.lower).cwiseMax(1e-300);
  return (rounded(x, set) - x).cwiseQuotient(range).cwiseAbs().maxCoeff() <= kRounding;
}

Matrix rows_in(const FeasibleSet& set, const Matrix& rows) {
  std::vector<Eigen::Index> inside;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (belongs_to(set, rows.row(i))) inside.push_back(i);
  return rows(inside, Eigen::all);
}

std::vector<Eigen::Index> ascending(const std::vector<double>& values) {
  std::vector<Eigen::Index> order(values.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto key = [&values](Eigen::Index i) {
    const double v = values[static_cast<std::size_t>(i)];
    return std::isnan(v) ? std::numeric_limits<double>::infinity() : v;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&key](Eigen::Index a, Eigen::Index b) { return key(a) < key(b); });
  return order;
}

BelievedModels::BelievedModels(std::span<const Surrogate> models, const Goal& goal,
                               const FeasibleSet& set, const ProposeOptions& options)
    : models_(models.begin(), models.end()),
      set_(set),
      known_(0, set.bounds.lower.size()),
      incumbents_(0, set.bounds.lower.size()),
      threads_(options.threads) {
  if (options.visited.rows() > 0 && options.belief != Belief::kriging)
    lie_ = lie_of(predict_rows(options.visited), goal, options.belief);
  append(options.visited);
  for (Eigen::Index i = 0; i < options.pending.rows(); ++i) believe(options.pending.row(i));
}

Predictions BelievedModels::predict(const Vector& x) const {
  Predictions p;
  p.reserve(models_.size());
  for (const Surrogate& model : models_) p.push_back(model.predict(x));
  return p;
}

std::vector<Predictions> BelievedModels::predict_rows(const Matrix& rows) const {
  std::vector<Predictions> of_model(models_.size());
  parallel_for(models_.size(), threads_,
               [&](std::size_t j) { of_model[j] = models_[j].predict_rows(rows); });
  std::vector<Predictions> of_row(static_cast<std::size_t>(rows.rows()));
  for (std::size_t i = 0; i < of_row.size(); ++i)
    for (const Predictions& p : of_model) of_row[i].push_back(p[i]);
  return of_row;
}

void BelievedModels::believe(const Vector& x) {
  bool lies = !lie_.empty();  // about a known point even a liar is believed nothing but the truth
  for (Eigen::Index i = 0; i < known_.rows() && lies; ++i) lies = known_.row(i) != x.transpose();
  for (std::size_t j = 0; j < models_.size(); ++j)
    models_[j] = models_[j].condition_on(x, lies ? lie_[j] : models_[j].predict(x).mean);
  append(x.transpose());
}

void BelievedModels::append(const Matrix& rows) {
  const auto extend = [](Matrix& all, const Matrix& more) {
    all.conservativeResize(all.rows() + more.rows(), Eigen::NoChange);
    all.bottomRows(more.rows()) = more;
  };
  if (rows.rows() == 0) return;
  extend(known_, rows);
  extend(incumbents_, rows_in(set_, rows));
}

}  // namespace repose::opt
