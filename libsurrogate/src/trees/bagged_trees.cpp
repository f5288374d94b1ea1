#include "repose/surrogate/bagged_trees.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "growing.hpp"
#include "importance.hpp"
#include "repose/base/error.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "states.hpp"

namespace repose::surrogate {
namespace {

using trees::Count;
using trees::Forest;

/// Bags and drawn predictors have streams of their own, so that a bag can be drawn again.
void draw_bag(std::uint64_t seed, std::size_t tree, std::span<Count> times) {
  RandomStream random(seed, tree);
  std::fill(times.begin(), times.end(), Count{0});
  for (std::size_t i = 0; i < times.size(); ++i)
    ++times[static_cast<std::size_t>(random.below(times.size()))];
}

RandomStream predictor_stream(std::uint64_t seed, std::size_t tree) {
  return RandomStream(derive_seed(seed, 0), tree);
}

/// The point of each row; bags hold points.
struct Points {
  explicit Points(const TrainingSet& data)
      : of_row(points_of(data)),
        number(static_cast<std::size_t>(*std::max_element(of_row.begin(), of_row.end()) + 1)) {}
  std::vector<Eigen::Index> of_row;
  std::size_t number;
};

/// How often each row is in the bag of each tree.
class Bags {
 public:
  Bags(std::uint64_t seed, std::size_t trees, const Points& points)
      : rows_(points.of_row.size()), times_(trees * rows_) {
    std::vector<Count> of_point(points.number);
    for (std::size_t t = 0; t < trees; ++t) {
      draw_bag(seed, t, of_point);
      for (std::size_t i = 0; i < rows_; ++i)
        times_[t * rows_ + i] = of_point[static_cast<std::size_t>(points.of_row[i])];
    }
  }
  std::span<const Count> of_tree(std::size_t tree) const {
    return std::span(times_).subspan(tree * rows_, rows_);
  }
  bool lacks(std::size_t tree, Eigen::Index row) const {
    return times_[tree * rows_ + static_cast<std::size_t>(row)] == 0;
  }

 private:
  std::size_t rows_;
  std::vector<Count> times_;
};

/// Trees first, first + stride, ...
template <class G>
void grow_trees(const TrainingSet& data, const trees::Columns& columns, const trees::Limits& limits,
                const Bags& bags, std::uint64_t seed, std::size_t first, std::size_t stride,
                std::vector<Forest>& forests) {
  G grower(columns, limits);
  const std::vector<double> weights = trees::weights_of(data);
  for (std::size_t t = first; t < forests.size(); t += stride) {
    RandomStream random = predictor_stream(seed, t);
    grower.grow(std::span(data.y.data(), weights.size()), weights, bags.of_tree(t), random);
    forests[t] = grower.forest();
  }
}

Forest grow_bag(const TrainingSet& data, const BaggedTreesOptions& options, const Bags& bags) {
  const trees::Columns columns(data.x, data.inputs);
  const trees::Limits limits = trees::limits_of(options.tree, columns);
  std::vector<Forest> forests(static_cast<std::size_t>(options.trees));
  const std::size_t parts =
      options.threads == 1 ? 1 : std::min<std::size_t>(forests.size(), 64);  // balanced
  parallel_for(parts, options.threads, [&](std::size_t part) {
    trees::with_sums_of(data, [&]<class G>(G*) {
      grow_trees<G>(data, columns, limits, bags, options.seed, part, parts, forests);
    });
  });
  return Forest(forests);
}

/// Means of the trees whose bag a row is not in; NaN where there is none.
Vector predict_out_of_bag(const Forest& forest, const Matrix& x, const Bags& bags) {
  Vector sum = Vector::Zero(x.rows());
  Vector number = Vector::Zero(x.rows());
  trees::for_each_leaf(
      forest, x, [&](std::size_t t, Eigen::Index first, std::span<const std::int32_t> leaves) {
        for (const std::int32_t leaf : leaves) {
          const double flag = bags.lacks(t, first) ? 1.0 : 0.0;
          sum[first] += flag * forest.means[static_cast<std::size_t>(leaf)];
          number[first++] += flag;
        }
      });
  return sum.cwiseQuotient(number);  // 0/0 is NaN
}

/// By weight, of the rows that have a prediction.
OutOfBag judged(Vector predicted, const TrainingSet& data) {
  const std::vector<double> weights = trees::weights_of(data);
  OutOfBag result{.predicted = std::move(predicted)};
  double weight = 0.0;
  double mean = 0.0;
  double squares = 0.0;
  const auto each_row = [&](auto use) {
    for (Eigen::Index i = 0; i < data.rows(); ++i)
      if (!std::isnan(result.predicted[i])) use(i, weights[static_cast<std::size_t>(i)]);
  };
  each_row([&](Eigen::Index i, double w) {
    ++result.rows;
    weight += w;
    mean += w * data.y[i];
    squares += w * std::pow(data.y[i] - result.predicted[i], 2);
  });
  mean /= weight;
  double spread = 0.0;
  each_row([&](Eigen::Index i, double w) { spread += w * std::pow(data.y[i] - mean, 2); });
  result.rmse = std::sqrt(squares / weight);
  result.q2 = 1.0 - squares / spread;
  return result;
}

/// The errors of rows in the leaves they fall into while out of bag, by weight.
void add_leaf_errors(TreeAccess::State<BaggedTrees>& state, const TrainingSet& data,
                     const Bags& bags) {
  state.squares.assign(state.forest.size(), 0.0);
  state.errors.assign(state.forest.size(), 0.0);
  const Vector square = (data.y - state.out_of_bag.predicted).cwiseAbs2();
  const std::vector<double> weights = trees::weights_of(data);
  trees::for_each_leaf(
      state.forest, data.x,
      [&](std::size_t t, Eigen::Index first, std::span<const std::int32_t> leaves) {
        for (const std::int32_t leaf : leaves) {
          const Eigen::Index i = first++;
          if (!bags.lacks(t, i)) continue;
          const double weight = weights[static_cast<std::size_t>(i)];
          state.squares[static_cast<std::size_t>(leaf)] += weight * square[i];
          state.errors[static_cast<std::size_t>(leaf)] += weight;
        }
      });
}

/// N_bi - 1 of [Wager2014], points x trees.
Matrix bag_matrix(std::uint64_t seed, Eigen::Index points, Eigen::Index number) {
  Matrix bags(points, number);
  std::vector<Count> times(static_cast<std::size_t>(points));
  for (Eigen::Index t = 0; t < number; ++t) {
    draw_bag(seed, static_cast<std::size_t>(t), times);
    for (Eigen::Index p = 0; p < points; ++p)
      bags(p, t) = static_cast<double>(times[static_cast<std::size_t>(p)]) - 1.0;
  }
  return bags;
}

/// V_IJ-U of [Wager2014] and the variance of the mean of so many trees.
Vector function_variance(const Matrix& of_trees, const Matrix& bags) {
  const auto number = static_cast<double>(of_trees.rows());
  const auto points = static_cast<double>(bags.rows());
  const Matrix centred = of_trees.rowwise() - of_trees.colwise().mean();
  const Vector squares = centred.colwise().squaredNorm();
  const Vector jackknife = (bags * centred / number).colwise().squaredNorm();
  const Vector corrected = jackknife - points / (number * number) * squares;
  return corrected.cwiseMax(0.0) + squares / (number * (number - 1.0));
}

/// [Lu2021]
Vector observation_variance(const TreeAccess::State<BaggedTrees>& state, const Matrix& x) {
  Vector squares = Vector::Zero(x.rows());
  Vector errors = Vector::Zero(x.rows());
  trees::for_each_leaf(state.forest, x,
                       [&](std::size_t, Eigen::Index first, std::span<const std::int32_t> leaves) {
                         for (const std::int32_t leaf : leaves) {
                           squares[first] += state.squares[static_cast<std::size_t>(leaf)];
                           errors[first++] += state.errors[static_cast<std::size_t>(leaf)];
                         }
                       });
  const double everywhere = state.out_of_bag.rmse * state.out_of_bag.rmse;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    squares[i] = errors[i] > 0.0 ? squares[i] / errors[i] : everywhere;
  return squares;
}

/// Rows out of a tree's bag, and how wrong the tree is there, by weight, when an input is exchanged
/// among them.
class TreeErrors {
 public:
  TreeErrors(const Forest& forest, std::size_t tree, const TrainingSet& rows)
      : forest_(forest),
        tree_(tree),
        inputs_(rows.dimension()),
        y_(rows.y),
        weights_(trees::weights_of(rows)) {
    trees::fill_block(rows.x, 0, rows.rows(), block_);
  }
  double mean_square() {
    trees::find_leaves(forest_, tree_, block_, y_.size(), inputs_, leaves_);
    double sum = 0.0;
    double weight = 0.0;
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      const double mean = forest_.means[static_cast<std::size_t>(leaves_[i])];
      sum += weights_[i] * std::pow(y_[static_cast<Eigen::Index>(i)] - mean, 2);
      weight += weights_[i];
    }
    return sum / weight;
  }
  double mean_square_without(Eigen::Index input, RandomStream& random) {
    std::vector<double> values;
    for (Eigen::Index i = 0; i < y_.size(); ++i) values.push_back(value(i, input));
    std::vector<double> exchanged = values;
    random.shuffle(exchanged);
    for (Eigen::Index i = 0; i < y_.size(); ++i)
      value(i, input) = exchanged[static_cast<std::size_t>(i)];
    const double result = mean_square();
    for (Eigen::Index i = 0; i < y_.size(); ++i)
      value(i, input) = values[static_cast<std::size_t>(i)];
    return result;
  }

 private:
  double& value(Eigen::Index row, Eigen::Index input) {
    return block_[trees::in_block(row, input, inputs_)];
  }

  const Forest& forest_;
  std::size_t tree_;
  Eigen::Index inputs_;
  Vector y_;
  std::vector<double> weights_;
  std::vector<double> block_;
  std::vector<std::int32_t> leaves_;
};

std::vector<bool> inputs_used(const Forest& forest, std::size_t tree, std::size_t inputs) {
  std::vector<bool> used(inputs, false);
  for (auto i = static_cast<std::size_t>(forest.trees[tree].root); i < forest.end_of(tree); ++i)
    if (!forest.node(i).is_leaf()) used[static_cast<std::size_t>(forest.node(i).input)] = true;
  return used;
}

}  // namespace

BaggedTrees BaggedTrees::fit(const TrainingSet& data, const BaggedTreesOptions& options) {
  check(data);
  if (options.trees < 1)
    throw InputError(fmt::format("{} trees in a bag; there must be at least 1", options.trees));
  trees::check_options(options.tree, data.dimension());
  const Points points(data);
  State state{.inputs = data.inputs,
              .options = options,
              .points = static_cast<Eigen::Index>(points.number)};
  const Bags bags(options.seed, static_cast<std::size_t>(options.trees), points);
  state.forest = grow_bag(data, options, bags);
  state.out_of_bag = judged(predict_out_of_bag(state.forest, data.x, bags), data);
  add_leaf_errors(state, data, bags);
  return TreeAccess::make<BaggedTrees>(std::move(state));
}

Vector BaggedTrees::predict(const Matrix& x) const {
  check_points(state_->inputs, x);
  Vector sum = Vector::Zero(x.rows());
  trees::add_predictions(state_->forest, x, 1.0, sum);
  return sum / static_cast<double>(state_->forest.trees.size());
}

Predictions BaggedTrees::predict_with_variances(const Matrix& x) const {
  Predictions result{.mean = predict(x)};
  if (state_->out_of_bag.rows > 0) result.observation_variance = observation_variance(*state_, x);
  const auto number = static_cast<Eigen::Index>(state_->forest.trees.size());
  if (number < 2) return result;
  const Matrix bags = bag_matrix(state_->options.seed, state_->points, number);
  result.function_variance.resize(x.rows());
  for (Eigen::Index first = 0; first < x.rows(); first += trees::kBlock) {
    const Eigen::Index rows = std::min(trees::kBlock, x.rows() - first);
    result.function_variance.segment(first, rows) = function_variance(
        trees::predictions_of_trees(state_->forest, x.middleRows(first, rows)), bags);
  }
  return result;
}

std::vector<Importance> BaggedTrees::importance(const TrainingSet& data, std::uint64_t seed) const {
  check(data);
  const Points points(data);
  if (static_cast<Eigen::Index>(points.number) != state_->points ||
      data.dimension() != static_cast<Eigen::Index>(inputs().size()))
    throw InputError(fmt::format(
        "the importance of inputs needs the data the model was fitted to: {} points of {} inputs, "
        "not {} of {}",
        state_->points, inputs().size(), points.number, data.dimension()));
  const auto number = state_->forest.trees.size();
  const Bags bags(state_->options.seed, number, points);
  const auto d = static_cast<std::size_t>(data.dimension());
  Matrix increase = Matrix::Zero(static_cast<Eigen::Index>(number), data.dimension());
  Eigen::Index judged_trees = 0;
  for (std::size_t t = 0; t < number; ++t) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < data.rows(); ++i)
      if (bags.lacks(t, i)) rows.push_back(i);
    if (rows.size() < 2) continue;
    TreeErrors errors(state_->forest, t, selected_rows(data, rows));
    const double before = errors.mean_square();
    const std::vector<bool> used = inputs_used(state_->forest, t, d);
    for (std::size_t k = 0; k < d; ++k) {
      RandomStream random(seed, t * d + k);
      if (used[k])
        increase(judged_trees, static_cast<Eigen::Index>(k)) =
            errors.mean_square_without(static_cast<Eigen::Index>(k), random) - before;
    }
    ++judged_trees;
  }
  if (judged_trees < 2)
    throw InputError(
        "fewer than two trees have rows out of their bags; grow more trees or give more rows");
  return trees::importance_of(increase.topRows(judged_trees));
}

const std::vector<Input>& BaggedTrees::inputs() const {
  return state_->inputs;
}

const BaggedTreesOptions& BaggedTrees::options() const {
  return state_->options;
}

const OutOfBag& BaggedTrees::out_of_bag() const {
  return state_->out_of_bag;
}

Eigen::Index BaggedTrees::points() const {
  return state_->points;
}

std::string BaggedTrees::describe() const {
  return fmt::format(
      "{} bagged trees{}", state_->options.trees,
      trees::describe(state_->options.tree, static_cast<Eigen::Index>(inputs().size())));
}

Trainer bagged_trees_trainer(std::string name, const BaggedTreesOptions& options) {
  return {std::move(name), [options](const TrainingSet& data, std::uint64_t seed) -> Regressor {
            BaggedTreesOptions o = options;
            o.seed = seed;
            return BaggedTrees::fit(data, o);
          }};
}

}  // namespace repose::surrogate
