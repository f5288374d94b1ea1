// Branch and bound over subsets of columns.
#include "best_subset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sweep.hpp"

namespace repose::doe {
namespace {

/// Less than this share of a column's squared length is rounding: it depends on those chosen.
constexpr double kDependent = 1e-16;

/// A bound on 1 - (smallest eigenvalue) of the correlation matrix of any `size` columns, by
/// Gershgorin's circles.
double departure_from_orthogonal(const Matrix& columns, const Vector& norms, int size) {
  const Vector scale = norms.cwiseSqrt().cwiseInverse();
  const Matrix correlation =
      (scale.asDiagonal() * (columns.transpose() * columns) * scale.asDiagonal()).cwiseAbs();
  double largest = 0.0;
  for (Eigen::Index j = 0; j < correlation.cols(); ++j) {
    std::vector<double> others;
    for (Eigen::Index k = 0; k < correlation.cols(); ++k)
      if (k != j) others.push_back(correlation(k, j));
    const auto most = std::min<std::size_t>(others.size(), static_cast<std::size_t>(size - 1));
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(most),
                      others.end(), std::greater<>());
    largest = std::max(
        largest,
        std::accumulate(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(most), 0.0));
  }
  return largest;
}

}  // namespace

SubsetSearch::SubsetSearch(const Vector& y, const Matrix& base, Matrix candidates)
    : residual_(y), candidates_(std::move(candidates)) {
  Sweep sweep(y);
  sweep.append_all(base);
  base_ = sweep.basis();
  residual_ = sweep.residual();
  base_df_ = sweep.residual_df();
  full_norm_ = candidates_.colwise().squaredNorm();
  for (int pass = 0; pass < 2; ++pass)
    candidates_ -= base_ * (base_.transpose() * candidates_).eval();
}

double SubsetSearch::residual_ss_with(const std::vector<int>& columns) const {
  Sweep sweep(residual_);
  for (const int column : columns)
    if (!sweep.append(candidates_.col(column), full_norm_(column)))
      return std::numeric_limits<double>::infinity();
  return sweep.residual_ss();
}

void SubsetSearch::keep_if_better(std::vector<int> columns, double residual_ss) {
  if (!(residual_ss < best_.residual_ss)) return;
  std::sort(columns.begin(), columns.end());
  best_.residual_ss = residual_ss;
  best_.columns = std::move(columns);
}

void SubsetSearch::greedy(int size, const std::vector<int>& near) {
  std::vector<int> chosen = near;
  const auto add_best = [&] {
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    Sweep sweep(residual_);
    for (const int column : chosen) sweep.append(candidates_.col(column), full_norm_(column));
    for (int candidate = 0; candidate < candidates_.cols(); ++candidate) {
      if (std::find(chosen.begin(), chosen.end(), candidate) != chosen.end()) continue;
      const double left = sweep.residual_ss_with(candidates_.col(candidate), full_norm_(candidate));
      if (left < least) {  // not NaN
        least = left;
        best = candidate;
      }
    }
    if (best >= 0) chosen.push_back(best);
    return least;
  };
  double least = std::numeric_limits<double>::infinity();
  while (static_cast<int>(chosen.size()) < size) {
    least = add_best();
    if (std::isinf(least)) return;
  }
  keep_if_better(chosen, least);
  for (bool improved = true; improved;) {  // exchange one for another while that helps
    improved = false;
    for (std::size_t i = 0; i < best_.columns.size(); ++i) {
      chosen = best_.columns;
      chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(i));
      const double left = add_best();
      if (left < best_.residual_ss * (1.0 - 1e-12)) {
        keep_if_better(chosen, left);
        improved = true;
      }
    }
  }
}

/// Of the residual, for the branches that choose the candidate at each place of `order` and others
/// behind it. They do not fall along the order.
std::vector<double> SubsetSearch::lower_bounds(const Node& node,
                                               const std::vector<Eigen::Index>& order,
                                               const Vector& explained, int missing) const {
  const double total = node.residual.squaredNorm();
  std::vector<double> bounds(order.size(), 0.0);
  const Vector norms = node.columns.colwise().squaredNorm();
  const double departure = departure_from_orthogonal(node.columns, norms, missing);
  for (std::size_t i = 0; i + static_cast<std::size_t>(missing) <= order.size(); ++i) {
    if (departure >= 1.0) break;
    double most = 0.0;
    for (int next = 0; next < missing; ++next)
      most += explained(order[i + static_cast<std::size_t>(next)]);
    bounds[i] = std::max(0.0, total - most / (1.0 - departure));
  }
  Sweep all(node.residual);
  for (std::size_t i = order.size(); i-- > 0;) {
    all.append(node.columns.col(order[i]));
    bounds[i] = std::max(bounds[i], all.residual_ss());
  }
  return bounds;
}

/// The candidate at `position` is chosen, those behind it are free.
SubsetSearch::Node SubsetSearch::child(const Node& node, const std::vector<Eigen::Index>& order,
                                       std::size_t position) const {
  const Vector unit = node.columns.col(order[position]).normalized();
  Node result{node.residual - unit * unit.dot(node.residual), {}, {}};
  std::vector<Eigen::Index> free;
  for (std::size_t i = position + 1; i < order.size(); ++i) {
    const int index = node.index[static_cast<std::size_t>(order[i])];
    const Vector column = node.columns.col(order[i]);
    const double left = (column - unit * unit.dot(column)).squaredNorm();
    if (!(left > kDependent * full_norm_(index))) continue;
    free.push_back(order[i]);
    result.index.push_back(index);
  }
  result.columns = node.columns(Eigen::all, free);
  result.columns -= unit * (unit.transpose() * result.columns).eval();
  return result;
}

void SubsetSearch::search(Node node, int missing, std::vector<int>& chosen) {
  if (best_.nodes == budget_) {
    best_.exact = false;
    return;
  }
  ++best_.nodes;
  const auto free = static_cast<std::size_t>(node.columns.cols());
  if (free < static_cast<std::size_t>(missing)) return;
  const Vector explained = (node.columns.transpose() * node.residual).array().square() /
                           node.columns.colwise().squaredNorm().transpose().array();
  std::vector<Eigen::Index> order(free);
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto i, auto j) { return explained(i) > explained(j); });
  const auto choose = [&](Eigen::Index at) {
    std::vector<int> columns = chosen;
    columns.push_back(node.index[static_cast<std::size_t>(at)]);
    return columns;
  };
  if (missing == 1) {
    const double estimate = node.residual.squaredNorm() - explained(order.front());
    if (estimate > best_.residual_ss * (1.0 + 1e-9)) return;
    std::vector<int> columns = choose(order.front());
    const double left = residual_ss_with(columns);
    return keep_if_better(std::move(columns), left);
  }
  const std::vector<double> bounds = lower_bounds(node, order, explained, missing);
  for (std::size_t i = 0; i + static_cast<std::size_t>(missing) <= free; ++i) {
    if (bounds[i] >= best_.residual_ss * (1.0 - 1e-12) || !best_.exact) break;
    std::vector<int> longer = choose(order[i]);
    search(child(node, order, i), missing - 1, longer);
  }
}

std::optional<BestSubset> SubsetSearch::best(int size, std::int64_t budget,
                                             const std::vector<int>& near) {
  best_ = {.columns = {},
           .residual_ss = std::numeric_limits<double>::infinity(),
           .exact = true,
           .nodes = 0};
  budget_ = budget;
  greedy(size, near);
  Node root{residual_, {}, {}};
  for (int j = 0; j < candidates_.cols(); ++j)
    if (candidates_.col(j).squaredNorm() > kDependent * full_norm_(j)) root.index.push_back(j);
  root.columns = candidates_(Eigen::all, root.index);
  std::vector<int> chosen;
  search(std::move(root), size, chosen);
  if (std::isinf(best_.residual_ss)) return std::nullopt;
  return best_;
}

}  // namespace repose::doe
