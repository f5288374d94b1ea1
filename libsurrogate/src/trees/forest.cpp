#include "forest.hpp"

namespace repose::surrogate::trees {
namespace {

using Position = std::uint32_t;

/// kLanes rows at once; all nodes divide numbers. Unrolled, the positions stay in registers.
void walk_numbers(const Forest& forest, TreeRange tree, const double* values,
                  std::int32_t* leaves) {
  const double* thresholds = forest.thresholds.data();
  const Forest::Link* links = forest.links.data();
  Position at[kLanes];
#pragma GCC unroll 8
  for (Eigen::Index lane = 0; lane < kLanes; ++lane) at[lane] = static_cast<Position>(tree.root);
  for (std::int32_t step = 0; step < tree.depth; ++step) {
#pragma GCC unroll 8
    for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
      const double x = values[static_cast<Position>(links[at[lane]].values) + lane];
      const bool left = x < thresholds[at[lane]];
      at[lane] = static_cast<Position>(links[at[lane]].left) + static_cast<Position>(!left);
    }
  }
#pragma GCC unroll 8
  for (Eigen::Index lane = 0; lane < kLanes; ++lane)
    leaves[lane] = static_cast<std::int32_t>(at[lane]);
}

/// One row of kLanes.
std::int32_t walk(const Forest& forest, std::int32_t root, const double* values) {
  auto at = static_cast<std::size_t>(root);
  for (Node node = forest.node(at); !node.is_leaf(); node = forest.node(at)) {
    const double x = values[node.input * kLanes];
    const bool left = node.is_categorical
                          ? forest.level_sets[static_cast<std::size_t>(node.threshold + x)] != 0
                          : x < node.threshold;
    at = static_cast<std::size_t>(node.left) + (left ? 0 : 1);
  }
  return static_cast<std::int32_t>(at);
}

}  // namespace

Forest::Forest(const std::vector<Forest>& parts) {
  std::size_t nodes = 0;
  for (const Forest& part : parts) nodes += part.size();
  thresholds.reserve(nodes);
  links.reserve(nodes);
  means.reserve(nodes);
  for (const Forest& part : parts) append(part);
}

void Forest::append(const Forest& other) {
  const std::size_t before = size();
  const auto shift = static_cast<std::int32_t>(before);
  const auto sets = static_cast<double>(level_sets.size());
  resize(before + other.size());
  for (std::size_t i = 0; i < other.size(); ++i) {
    Node node = other.node(i);
    node.left += shift;
    if (node.is_categorical) node.threshold += sets;
    set(before + i, node);
  }
  for (const TreeRange& tree : other.trees) trees.push_back({tree.root + shift, tree.depth});
  means.insert(means.end(), other.means.begin(), other.means.end());
  level_sets.insert(level_sets.end(), other.level_sets.begin(), other.level_sets.end());
}

void fill_block(const Matrix& x, Eigen::Index first, Eigen::Index rows,
                std::vector<double>& block) {
  const Eigen::Index d = x.cols();
  block.assign(static_cast<std::size_t>((rows + kLanes - 1) / kLanes * kLanes * d), 0.0);
  double* to = block.data();
  for (Eigen::Index i = 0; i < rows; i += kLanes) {
    const Eigen::Index lanes = std::min(kLanes, rows - i);
    for (Eigen::Index k = 0; k < d; ++k, to += kLanes)
      std::copy_n(x.col(k).data() + first + i, lanes, to);
  }
}

void find_leaves(const Forest& forest, std::size_t tree, const std::vector<double>& block,
                 Eigen::Index rows, Eigen::Index inputs, std::vector<std::int32_t>& leaves) {
  const TreeRange range = forest.trees[tree];
  leaves.resize(static_cast<std::size_t>((rows + kLanes - 1) / kLanes * kLanes));
  const double* values = block.data();
  for (Eigen::Index i = 0; i < rows; i += kLanes, values += kLanes * inputs) {
    std::int32_t* found = leaves.data() + i;
    const Eigen::Index lanes = std::min(kLanes, rows - i);
    if (forest.has_categories || lanes < 3)
      for (Eigen::Index lane = 0; lane < lanes; ++lane)
        found[lane] = walk(forest, range.root, values + lane);
    else
      walk_numbers(forest, range, values, found);
  }
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
