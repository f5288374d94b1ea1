// What fitted trees and ensembles hold; shared by their implementations and by model files.
#pragma once

#include "forest.hpp"
#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/tree.hpp"

namespace repose::surrogate {

struct RegressionTree::State {
  std::vector<Input> inputs = {};
  TreeOptions options = {};
  trees::Forest forest = {};
};

struct BaggedTrees::State {
  std::vector<Input> inputs = {};
  BaggedTreesOptions options = {};
  trees::Forest forest = {};
  Eigen::Index points = 0;
  OutOfBag out_of_bag = {};
  /// Of the rows that were out of a leaf's bag and fall into it: sum of their squared out-of-bag
  /// errors, and their number, both by weight. One for each node; 0 for those that are no leaves.
  std::vector<double> squares = {};
  std::vector<double> errors = {};
};

struct BoostedTrees::State {
  std::vector<Input> inputs = {};
  BoostedTreesOptions options = {};
  trees::Forest forest = {};
  double constant = 0.0;
  std::vector<double> held_out_rmse = {};
};

struct TreeAccess {
  template <class M>
  using State = typename M::State;
  template <class M>
  static const State<M>& state(const M& model) {
    return *model.state_;
  }
  template <class M>
  static M make(State<M> state) {
    return M(std::make_shared<const State<M>>(std::move(state)));
  }
};

}  // namespace repose::surrogate
