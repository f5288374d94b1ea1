// Data of the tests of trees: all kinds of inputs, a table like those of screening designs, and a
// tree found by trying everything.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "gp_data.hpp"
#include "repose/surrogate/tree.hpp"

namespace repose::surrogate::test {

/// A number with many values, one with four, one on a log scale, a category of five levels.
inline std::vector<Input> mixed_inputs() {
  return {{},
          {.upper = 3.0},
          {.lower = 1.0, .upper = 1e4, .scale = Scale::log},
          {.levels = {"a", "b", "c", "d", "e"}}};
}

inline TrainingSet mixed_sample(Eigen::Index n, std::uint64_t seed) {
  Matrix x = uniform_points(n, 4, seed);
  x.col(1) = (x.col(1) * 4.0).array().floor();
  x.col(2) = Eigen::pow(10.0, 4.0 * x.col(2).array());
  x.col(3) = (x.col(3) * 5.0).array().floor();
  RandomStream random(seed, 1);
  Vector y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double level = std::fmod(3.0 * x(i, 3), 5.0);
    y[i] = std::sin(6.0 * x(i, 0)) + 0.4 * x(i, 1) * level + 0.1 * std::log(x(i, 2)) +
           0.3 * random.normal();
  }
  return {.x = x, .y = y, .inputs = mixed_inputs()};
}

/// A tree by trying every division of every node, categories in all their subsets.
class ExhaustiveTree {
 public:
  ExhaustiveTree(const TrainingSet& data, const TreeOptions& options)
      : data_(data), options_(options) {
    std::vector<Eigen::Index> all;
    for (Eigen::Index i = 0; i < data.rows(); ++i) all.push_back(i);
    nodes_.push_back({.rows = all});
    std::size_t first = 0;
    Eigen::Index splits = 0;
    for (Eigen::Index depth = 0; depth < options.maximum_depth.value_or(1000); ++depth) {
      const std::size_t last = nodes_.size();
      std::vector<std::size_t> order;
      for (std::size_t i = first; i < last; ++i) {
        find_split(nodes_[i]);
        if (nodes_[i].input >= 0) order.push_back(i);
      }
      std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
        return nodes_[a].gain > nodes_[b].gain;
      });
      const auto room = static_cast<std::size_t>(options.maximum_splits.value_or(100000) - splits);
      for (std::size_t k = room; k < order.size(); ++k) nodes_[order[k]].input = -1;
      splits += static_cast<Eigen::Index>(std::min(room, order.size()));
      for (std::size_t i = first; i < last; ++i) divide(i);
      if (nodes_.size() == last) break;
      first = last;
    }
  }

  Vector predict(const Matrix& x) const {
    Vector y(x.rows());
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      std::size_t at = 0;
      while (nodes_[at].input >= 0)
        at = nodes_[at].left + (goes_left(nodes_[at], x.row(i)) ? 0 : 1);
      y[i] = mean(nodes_[at].rows);
    }
    return y;
  }
  std::size_t nodes() const { return nodes_.size(); }

 private:
  struct Node {
    std::vector<Eigen::Index> rows;
    double gain = 0.0;
    Eigen::Index input = -1;
    double threshold = 0.0;
    std::vector<bool> levels = {};
    std::size_t left = 0;
  };

  double weight(Eigen::Index i) const { return data_.weights.size() > 0 ? data_.weights[i] : 1.0; }
  double weight(const std::vector<Eigen::Index>& rows) const {
    double sum = 0.0;
    for (const Eigen::Index i : rows) sum += weight(i);
    return sum;
  }
  double mean(const std::vector<Eigen::Index>& rows) const {
    double sum = 0.0;
    for (const Eigen::Index i : rows) sum += weight(i) * data_.y[i];
    return sum / weight(rows);
  }
  double squares(const std::vector<Eigen::Index>& rows) const {
    double sum = 0.0;
    for (const Eigen::Index i : rows) sum += weight(i) * std::pow(data_.y[i] - mean(rows), 2);
    return sum;
  }
  template <class RowLike>
  static bool goes_left(const Node& node, const RowLike& row) {
    const double value = row[node.input];
    return node.levels.empty() ? value < node.threshold
                               : node.levels[static_cast<std::size_t>(value)];
  }
  std::vector<Eigen::Index> part(const Node& node, bool left) const {
    std::vector<Eigen::Index> rows;
    for (const Eigen::Index i : node.rows)
      if (goes_left(node, data_.x.row(i)) == left) rows.push_back(i);
    return rows;
  }
  void consider(Node& best, Node candidate) const {
    const auto left = part(candidate, true);
    const auto right = part(candidate, false);
    const auto least = static_cast<std::size_t>(options_.minimum_leaf);
    if (left.size() < least || right.size() < least) return;
    candidate.gain = squares(candidate.rows) - squares(left) - squares(right);
    if (candidate.gain > best.gain + 1e-10 * squares(candidate.rows)) best = candidate;
  }
  void find_split(Node& node) const {
    Node best = node;
    for (Eigen::Index k = 0; k < data_.dimension(); ++k) {
      const Input& input = data_.inputs[static_cast<std::size_t>(k)];
      Node candidate{.rows = node.rows, .input = k};
      if (input.is_categorical()) {
        try_subsets(best, candidate);
        continue;
      }
      std::vector<double> values;
      for (const Eigen::Index i : node.rows) values.push_back(data_.x(i, k));
      std::sort(values.begin(), values.end());
      for (std::size_t v = 1; v < values.size(); ++v) {
        if (values[v - 1] == values[v]) continue;
        candidate.threshold = input.scale == Scale::log ? std::sqrt(values[v - 1] * values[v])
                                                        : (values[v - 1] + values[v]) / 2.0;
        consider(best, candidate);
      }
    }
    node = best;
  }
  /// Of the levels that the node has; the part with the smaller mean is left, absent ones go with
  /// the heavier part.
  void try_subsets(Node& best, Node candidate) const {
    const auto number = data_.inputs[static_cast<std::size_t>(candidate.input)].levels.size();
    std::vector<std::size_t> present;
    for (std::size_t l = 0; l < number; ++l)
      for (const Eigen::Index i : candidate.rows)
        if (data_.x(i, candidate.input) == static_cast<double>(l)) {
          present.push_back(l);
          break;
        }
    for (std::size_t subset = 1; subset + 1 < (std::size_t{1} << present.size()); ++subset) {
      candidate.levels.assign(number, false);
      for (std::size_t p = 0; p < present.size(); ++p)
        candidate.levels[present[p]] = (subset >> p & 1) != 0;
      const auto left = part(candidate, true);
      const auto right = part(candidate, false);
      if (mean(left) > mean(right)) continue;  // its complement is tried too
      if (options_.minimum_leaf > 1 && !in_order(candidate, left, right)) continue;
      for (std::size_t l = 0; l < number; ++l)
        if (std::find(present.begin(), present.end(), l) == present.end())
          candidate.levels[l] = weight(left) >= weight(right);
      consider(best, candidate);
    }
  }
  /// Whether all levels on the left have smaller means, which a minimum leaf can make worse than
  /// another division.
  bool in_order(const Node& node, const std::vector<Eigen::Index>& left,
                const std::vector<Eigen::Index>& right) const {
    const auto mean_of_level_of = [&](Eigen::Index row) {
      std::vector<Eigen::Index> level;
      for (const Eigen::Index i : node.rows)
        if (data_.x(i, node.input) == data_.x(row, node.input)) level.push_back(i);
      return mean(level);
    };
    for (const Eigen::Index a : left)
      for (const Eigen::Index b : right)
        if (mean_of_level_of(a) > mean_of_level_of(b)) return false;
    return true;
  }
  void divide(std::size_t i) {
    if (nodes_[i].input < 0) return;
    nodes_[i].left = nodes_.size();
    for (const bool left : {true, false}) {
      Node child{.rows = part(nodes_[i], left)};
      nodes_.push_back(std::move(child));
    }
  }

  TrainingSet data_;
  TreeOptions options_;
  std::vector<Node> nodes_;
};

}  // namespace repose::surrogate::test
