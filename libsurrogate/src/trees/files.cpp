// Trees and ensembles in model files.
#include <algorithm>
#include <array>
#include <cmath>

#include "model_kinds.hpp"
#include "states.hpp"

namespace repose::surrogate {
namespace {

using table::Table;
using trees::Forest;
using trees::Node;

constexpr std::array kStoppings{Stopping::none, Stopping::held_out, Stopping::k_fold};

std::int64_t or_zero(const std::optional<Eigen::Index>& value) {
  return static_cast<std::int64_t>(value.value_or(0));
}

void add_tree_options(const TreeOptions& options, table::Attributes& attributes) {
  attributes["minimum_leaf"] = static_cast<std::int64_t>(options.minimum_leaf);
  attributes["maximum_splits"] = or_zero(options.maximum_splits);
  attributes["maximum_depth"] = or_zero(options.maximum_depth);
  attributes["predictors"] = or_zero(options.predictors);
}

std::int64_t positive(const ModelReader& file, const char* name) {
  const auto value = file.get<std::int64_t>(name);
  if (value < 1)
    file.damaged(fmt::format("attribute '{}' is {}; it must be positive", name, value));
  return value;
}

TreeOptions read_tree_options(const ModelReader& file) {
  const auto optional = [&file](const char* name) -> std::optional<Eigen::Index> {
    const auto value = file.get<std::int64_t>(name);
    return value > 0 ? std::optional<Eigen::Index>(value) : std::nullopt;
  };
  return {.minimum_leaf = positive(file, "minimum_leaf"),
          .maximum_splits = optional("maximum_splits"),
          .maximum_depth = optional("maximum_depth"),
          .predictors = optional("predictors")};
}

void add_forest(const Forest& forest, ModelContent& content) {
  std::vector<std::int64_t> root;
  std::vector<std::int64_t> depth;
  for (const trees::TreeRange& tree : forest.trees) {
    root.push_back(tree.root);
    depth.push_back(tree.depth);
  }
  std::vector<std::int64_t> input;
  std::vector<std::int64_t> left;
  std::vector<std::int64_t> level_set;
  std::vector<double> threshold;
  for (std::size_t i = 0; i < forest.size(); ++i) {
    const Node node = forest.node(i);
    input.push_back(node.is_leaf() ? -1 : node.input);
    left.push_back(node.left);
    level_set.push_back(node.is_categorical ? static_cast<std::int64_t>(node.threshold) : -1);
    threshold.push_back(node.is_leaf() || node.is_categorical ? 0.0 : node.threshold);
  }
  Table of_trees;
  add_column(of_trees, "root", root);
  add_column(of_trees, "depth", depth);
  Table of_nodes;
  add_column(of_nodes, "input", input);
  add_column(of_nodes, "threshold", threshold);
  add_column(of_nodes, "level_set", level_set);
  add_column(of_nodes, "left", left);
  add_column(of_nodes, "mean", forest.means);
  Table sets;
  add_column(sets, "left",
             std::vector<std::int64_t>(forest.level_sets.begin(), forest.level_sets.end()));
  content.add("/trees", std::move(of_trees));
  content.add("/nodes", std::move(of_nodes));
  content.add("/level_sets", std::move(sets));
}

/// Whatever the file says, a walk ends at a leaf of its tree and reads nothing outside.
class ForestReader {
 public:
  ForestReader(const ModelReader& file, const std::vector<Input>& inputs)
      : file_(file), inputs_(inputs) {}

  Forest read() {
    if (!file_.has_table("/trees")) return forest_;
    read_trees();
    if (file_.has_table("/level_sets"))
      for (const std::int64_t flag : file_.read("/level_sets").integers("left"))
        forest_.level_sets.push_back(flag == 0 ? 0 : 1);
    const Table t = file_.read("/nodes");
    forest_.means = t.numbers("mean");
    const auto input = t.integers("input");
    const auto left = t.integers("left");
    const auto level_set = t.integers("level_set");
    const auto threshold = t.numbers("threshold");
    forest_.resize(t.rows());
    for (std::size_t i = 0; i < t.rows(); ++i)
      read_node(i, input[i], left[i], level_set[i], threshold[i]);
    check_trees();
    return std::move(forest_);
  }

 private:
  void read_trees() {
    const Table t = file_.read("/trees");
    const auto root = t.integers("root");
    const auto depth = t.integers("depth");
    for (std::size_t i = 0; i < t.rows(); ++i) {
      file_.check(root[i] >= (i == 0 ? 0 : root[i - 1] + 1) && root[i] < (1LL << 31) &&
                      depth[i] >= 0 && depth[i] < (1LL << 31),
                  "/trees has roots that are not in order");
      forest_.trees.push_back(
          {static_cast<std::int32_t>(root[i]), static_cast<std::int32_t>(depth[i])});
    }
    file_.check(!root.empty() && root.front() == 0, "/trees does not begin with node 0");
  }
  void read_node(std::size_t i, std::int64_t input, std::int64_t left, std::int64_t level_set,
                 double threshold) {
    file_.check(left >= 0 && left < static_cast<std::int64_t>(forest_.size()),
                "/nodes has a child that is not there");
    Node node{.left = static_cast<std::int32_t>(left)};
    if (input < 0) {
      file_.check(left == static_cast<std::int64_t>(i), "a leaf of /nodes leads elsewhere");
      return forest_.set(i, node);
    }
    file_.check(input < static_cast<std::int64_t>(inputs_.size()),
                "/nodes names an input that is not there");
    const Input& what = inputs_[static_cast<std::size_t>(input)];
    node.input = static_cast<std::int32_t>(input);
    node.is_categorical = what.is_categorical();
    node.threshold = node.is_categorical ? static_cast<double>(level_set) : threshold;
    file_.check(!node.is_categorical ||
                    (level_set >= 0 && static_cast<std::size_t>(level_set) + what.levels.size() <=
                                           forest_.level_sets.size()),
                "/nodes names levels that are not there");
    forest_.set(i, node);
  }
  /// Children lie behind their parents in the same tree, which is as deep as its deepest node: a
  /// walk takes that many steps.
  void check_trees() const {
    for (std::size_t t = 0; t < forest_.trees.size(); ++t) {
      const auto begin = static_cast<std::size_t>(forest_.trees[t].root);
      const std::size_t end = forest_.end_of(t);
      file_.check(begin < end && end <= forest_.size(), "/trees has a tree without nodes");
      std::vector<std::int32_t> depth(end - begin, 0);
      for (std::size_t i = begin; i < end; ++i) {
        const Node node = forest_.node(i);
        if (node.is_leaf()) continue;
        const auto left = static_cast<std::size_t>(node.left);
        file_.check(node.left > static_cast<std::int32_t>(i) && left + 1 < end,
                    "/nodes has a child outside of its tree");
        for (const std::size_t child : {left, left + 1})
          depth[child - begin] = std::max(depth[child - begin], depth[i - begin] + 1);
      }
      file_.check(*std::max_element(depth.begin(), depth.end()) == forest_.trees[t].depth,
                  "/trees has a tree of another depth than its nodes");
    }
  }

  const ModelReader& file_;
  const std::vector<Input>& inputs_;
  Forest forest_;
};

Forest read_forest(const ModelReader& file, const std::vector<Input>& inputs) {
  return ForestReader(file, inputs).read();
}

std::uint64_t read_seed(const ModelReader& file) {
  return static_cast<std::uint64_t>(file.get<std::int64_t>("seed"));
}

}  // namespace

std::optional<ModelContent> write_tree(const Regressor& regressor) {
  const auto* model = regressor.target<RegressionTree>();
  if (model == nullptr) return std::nullopt;
  const auto& s = TreeAccess::state(*model);
  ModelContent content;
  add_tree_options(s.options, content.attributes);
  add_forest(s.forest, content);
  return content;
}

Regressor read_tree(const ModelReader& file, std::vector<Input> inputs) {
  TreeAccess::State<RegressionTree> s{.options = read_tree_options(file),
                                      .forest = read_forest(file, inputs)};
  file.check(s.forest.trees.size() == 1, "/trees has not one tree");
  s.inputs = std::move(inputs);
  return TreeAccess::make<RegressionTree>(std::move(s));
}

std::optional<ModelContent> write_bagged_trees(const Regressor& regressor) {
  const auto* model = regressor.target<BaggedTrees>();
  if (model == nullptr) return std::nullopt;
  const auto& s = TreeAccess::state(*model);
  ModelContent content;
  add_tree_options(s.options.tree, content.attributes);
  content.attributes["seed"] = static_cast<std::int64_t>(s.options.seed);
  content.attributes["points"] = static_cast<std::int64_t>(s.points);
  content.attributes["out_of_bag_rows"] = static_cast<std::int64_t>(s.out_of_bag.rows);
  if (s.out_of_bag.rows > 0) {
    content.attributes["out_of_bag_rmse"] = s.out_of_bag.rmse;
    content.attributes["out_of_bag_q2"] = s.out_of_bag.q2;
  }
  add_forest(s.forest, content);
  Table errors;
  add_column(errors, "squares", s.squares);
  add_column(errors, "errors", s.errors);
  content.add("/leaf_errors", std::move(errors));
  Table rows;
  std::vector<double> predicted = doubles(s.out_of_bag.predicted);
  std::vector<std::int64_t> known;
  for (double& value : predicted) {
    known.push_back(std::isnan(value) ? 0 : 1);
    if (std::isnan(value)) value = 0.0;
  }
  add_column(rows, "predicted", std::move(predicted));
  add_column(rows, "known", std::move(known));
  content.add("/out_of_bag", std::move(rows));
  return content;
}

Regressor read_bagged_trees(const ModelReader& file, std::vector<Input> inputs) {
  TreeAccess::State<BaggedTrees> s;
  s.forest = read_forest(file, inputs);
  file.check(!s.forest.trees.empty(), "there are no /trees");
  s.options = {.trees = static_cast<Eigen::Index>(s.forest.trees.size()),
               .tree = read_tree_options(file),
               .seed = read_seed(file)};
  s.points = positive(file, "points");
  const Table errors = file.read("/leaf_errors");
  s.squares = errors.numbers("squares");
  s.errors = errors.numbers("errors");
  file.check(errors.rows() == s.forest.size(), "/leaf_errors has not a row for each node");
  const Table rows = file.read("/out_of_bag");
  s.out_of_bag.predicted = vector_of(rows.numbers("predicted"));
  const auto known = rows.integers("known");
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i] == 0) s.out_of_bag.predicted[static_cast<Eigen::Index>(i)] = std::nan("");
  file.check(s.points <= static_cast<Eigen::Index>(rows.rows()),
             "attribute 'points' is more than /out_of_bag has rows");
  s.out_of_bag.rows = file.get<std::int64_t>("out_of_bag_rows");
  s.out_of_bag.rmse = s.out_of_bag.q2 = std::nan("");
  if (s.out_of_bag.rows > 0) {
    s.out_of_bag.rmse = file.positive_or_zero("out_of_bag_rmse");
    s.out_of_bag.q2 = file.get<double>("out_of_bag_q2");
  }
  s.inputs = std::move(inputs);
  return TreeAccess::make<BaggedTrees>(std::move(s));
}

std::optional<ModelContent> write_boosted_trees(const Regressor& regressor) {
  const auto* model = regressor.target<BoostedTrees>();
  if (model == nullptr) return std::nullopt;
  const auto& s = TreeAccess::state(*model);
  ModelContent content;
  add_tree_options(s.options.tree, content.attributes);
  content.attributes["learning_rate"] = s.options.learning_rate;
  content.attributes["trees"] = static_cast<std::int64_t>(s.options.trees);
  content.attributes["fitted_trees"] = static_cast<std::int64_t>(s.forest.trees.size());
  content.attributes["stopping"] = std::string(to_string(s.options.stopping));
  content.attributes["folds"] = static_cast<std::int64_t>(s.options.folds);
  content.attributes["seed"] = static_cast<std::int64_t>(s.options.seed);
  content.attributes["constant"] = s.constant;
  add_forest(s.forest, content);
  Table curve;
  add_column(curve, "rmse", s.held_out_rmse);
  content.add("/held_out", std::move(curve));
  return content;
}

Regressor read_boosted_trees(const ModelReader& file, std::vector<Input> inputs) {
  TreeAccess::State<BoostedTrees> s;
  s.options = {.trees = file.get<std::int64_t>("trees"),
               .learning_rate = file.get<double>("learning_rate"),
               .tree = read_tree_options(file),
               .stopping = file.choice(file.get<std::string>("stopping"), kStoppings),
               .folds = file.get<std::int64_t>("folds"),
               .seed = read_seed(file)};
  s.forest = read_forest(file, inputs);
  if (file.version() > 1)  // without trees the model is a constant
    file.check(
        file.get<std::int64_t>("fitted_trees") == static_cast<std::int64_t>(s.forest.trees.size()),
        "/trees has not as many as attribute 'fitted_trees' says");
  s.constant = file.get<double>("constant");
  if (file.has_table("/held_out")) s.held_out_rmse = file.read("/held_out").numbers("rmse");
  s.inputs = std::move(inputs);
  return TreeAccess::make<BoostedTrees>(std::move(s));
}

}  // namespace repose::surrogate
