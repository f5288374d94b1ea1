#include "repose/surrogate/tree.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "growing.hpp"
#include "states.hpp"

namespace repose::surrogate {
namespace {

template <class G>
trees::Forest grown(const trees::Columns& columns, const trees::Limits& limits,
                    const TrainingSet& data, std::uint64_t seed) {
  G grower(columns, limits);
  RandomStream random(seed);
  const std::vector<trees::Count> once(static_cast<std::size_t>(data.rows()), 1);
  grower.grow(std::span(data.y.data(), once.size()), trees::weights_of(data), once, random);
  return grower.forest();
}

}  // namespace

RegressionTree RegressionTree::fit(const TrainingSet& data, const TreeOptions& options,
                                   std::uint64_t seed) {
  check(data);
  trees::check_options(options, data.dimension());
  const trees::Columns columns(data.x, data.inputs);
  const trees::Limits limits = trees::limits_of(options, columns);
  State state{.inputs = data.inputs, .options = options};
  state.forest =
      trees::with_sums_of(data, [&]<class G>(G*) { return grown<G>(columns, limits, data, seed); });
  return TreeAccess::make<RegressionTree>(std::move(state));
}

Vector RegressionTree::predict(const Matrix& x) const {
  check_points(state_->inputs, x);
  Vector mean = Vector::Zero(x.rows());
  trees::add_predictions(state_->forest, x, 1.0, mean);
  return mean;
}

const std::vector<Input>& RegressionTree::inputs() const {
  return state_->inputs;
}

const TreeOptions& RegressionTree::options() const {
  return state_->options;
}

std::string RegressionTree::describe() const {
  return fmt::format("regression tree of {} leaves{}", leaves(),
                     trees::describe(state_->options, static_cast<Eigen::Index>(inputs().size())));
}

std::vector<TreeNode> RegressionTree::nodes() const {
  const trees::Forest& f = state_->forest;
  std::vector<TreeNode> result;
  for (std::size_t i = 0; i < f.size(); ++i) {
    const trees::Node node = f.node(i);
    TreeNode n{.mean = f.means[i]};
    if (!node.is_leaf()) {
      n.input = node.input;
      n.left = node.left;
      if (node.is_categorical) {
        const auto set = f.level_sets.begin() + static_cast<std::ptrdiff_t>(node.threshold);
        const auto levels = inputs()[static_cast<std::size_t>(n.input)].levels.size();
        n.left_levels.assign(set, set + static_cast<std::ptrdiff_t>(levels));
      } else {
        n.threshold = node.threshold;
      }
    }
    result.push_back(std::move(n));
  }
  return result;
}

Eigen::Index RegressionTree::leaves() const {
  const auto& thresholds = state_->forest.thresholds;
  return std::count(thresholds.begin(), thresholds.end(), trees::Node::kLeaf);
}

Eigen::Index RegressionTree::depth() const {
  return state_->forest.trees.front().depth;
}

Trainer tree_trainer(std::string name, const TreeOptions& options) {
  return {std::move(name), [options](const TrainingSet& data, std::uint64_t seed) -> Regressor {
            return RegressionTree::fit(data, options, seed);
          }};
}

}  // namespace repose::surrogate
