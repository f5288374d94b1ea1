#include "forest.hpp"

namespace repose::surrogate::trees {
namespace {

/// Rows whose walks overlap, so that none waits for the others' loads.
constexpr Eigen::Index kLanes = 8;

/// All nodes divide numbers.
void walk_numbers(const Node* nodes, TreeRange tree, const double* block, Eigen::Index inputs,
                  std::int32_t* leaves) {
  std::int32_t at[kLanes];
  for (Eigen::Index lane = 0; lane < kLanes; ++lane) at[lane] = tree.root;
  for (std::int32_t step = 0; step < tree.depth; ++step)
    for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
      const Node& node = nodes[at[lane]];
      const double x = block[lane * inputs + node.input];
      at[lane] = node.left + static_cast<std::int32_t>(!(x < node.threshold));
    }
  for (Eigen::Index lane = 0; lane < kLanes; ++lane) leaves[lane] = at[lane];
}

std::int32_t walk(const Forest& forest, std::int32_t root, const double* row) {
  std::int32_t at = root;
  while (!forest.nodes[static_cast<std::size_t>(at)].is_leaf()) {
    const Node& node = forest.nodes[static_cast<std::size_t>(at)];
    const double x = row[node.column()];
    const bool left = node.is_categorical()
                          ? forest.level_sets[static_cast<std::size_t>(node.threshold + x)] != 0
                          : x < node.threshold;
    at = node.left + (left ? 0 : 1);
  }
  return at;
}

}  // namespace

void Forest::append(const Forest& other) {
  const auto shift = static_cast<std::int32_t>(nodes.size());
  const auto sets = static_cast<double>(level_sets.size());
  for (Node node : other.nodes) {
    node.left += shift;
    if (node.is_categorical()) node.threshold += sets;
    nodes.push_back(node);
  }
  for (const TreeRange& tree : other.trees) trees.push_back({tree.root + shift, tree.depth});
  means.insert(means.end(), other.means.begin(), other.means.end());
  level_sets.insert(level_sets.end(), other.level_sets.begin(), other.level_sets.end());
  has_categories = has_categories || other.has_categories;
}

void transpose_block(const Matrix& x, Eigen::Index first, Eigen::Index rows,
                     std::vector<double>& block) {
  const Eigen::Index d = x.cols();
  block.resize(static_cast<std::size_t>(rows * d));
  for (Eigen::Index k = 0; k < d; ++k)
    for (Eigen::Index i = 0; i < rows; ++i)
      block[static_cast<std::size_t>(i * d + k)] = x(first + i, k);
}

void find_leaves(const Forest& forest, std::size_t tree, const double* block, Eigen::Index rows,
                 Eigen::Index inputs, std::int32_t* leaves) {
  const TreeRange range = forest.trees[tree];
  Eigen::Index i = 0;
  if (!forest.has_categories)
    for (; i + kLanes <= rows; i += kLanes)
      walk_numbers(forest.nodes.data(), range, block + i * inputs, inputs, leaves + i);
  for (; i < rows; ++i) leaves[i] = walk(forest, range.root, block + i * inputs);
}

void add_predictions(const Forest& forest, const Matrix& x, double weight, Vector& sum) {
  for_each_leaf(forest, x,
                [&](std::size_t, Eigen::Index first, std::span<const std::int32_t> leaves) {
                  double* to = sum.data() + first;
                  for (std::size_t i = 0; i < leaves.size(); ++i)
                    to[i] += weight * forest.means[static_cast<std::size_t>(leaves[i])];
                });
}

Matrix predictions_of_trees(const Forest& forest, const Matrix& x) {
  Matrix result(static_cast<Eigen::Index>(forest.trees.size()), x.rows());
  for_each_leaf(forest, x,
                [&](std::size_t t, Eigen::Index first, std::span<const std::int32_t> leaves) {
                  for (const std::int32_t leaf : leaves)
                    result(static_cast<Eigen::Index>(t), first++) =
                        forest.means[static_cast<std::size_t>(leaf)];
                });
  return result;
}

}  // namespace repose::surrogate::trees
