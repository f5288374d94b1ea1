// Trees as measured by bench/tree_peers.py, beside scikit-learn on the same rows and folds.
//
//   repose_tree_peers table KIND SEED          CSV: fold, y, x1 ... x18
//   repose_tree_peers run KIND SEED MODEL      JSON: fit_seconds and rmse in ten folds, seconds of
//                                              predicting 185 and 10,000 rows by the model of all
// KIND: screening (185 rows of five groups) or uniform (as many rows of uniform inputs); MODEL: bag
// (100 trees, leaves of 1) or boosting (100 trees of depth 4). Times are of the calls alone.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "grouped_screening.hpp"
#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace {

using namespace repose;
using namespace repose::surrogate;
using Clock = std::chrono::steady_clock;

TrainingSet table_of(const std::string& kind, std::uint64_t seed) {
  TrainingSet data = test::grouped_screening(seed).data;
  if (kind == "screening") return data;
  RandomStream random(seed, 1);
  for (Eigen::Index i = 0; i < data.rows(); ++i) {
    for (Eigen::Index k = 0; k < data.dimension(); ++k) {
      const Input& input = data.inputs[static_cast<std::size_t>(k)];
      data.x(i, k) = random.uniform(input.lower, input.upper);
    }
    data.y[i] = test::grouped_response(data.x.row(i)) + 0.01 * random.normal();
  }
  return data;
}

std::vector<Fold> folds_of(const TrainingSet& data, std::uint64_t seed) {
  return k_folds(data, {.folds = 10, .seed = seed});
}

Trainer trainer_of(const std::string& model) {
  if (model == "bag") return bagged_trees_trainer(model, {.trees = 100});
  return boosted_trees_trainer(model,
                               {.trees = 100, .tree = {.minimum_leaf = 1, .maximum_depth = 4}});
}

template <class Call>
double seconds_of(Call call) {
  const auto start = Clock::now();
  call();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Smallest of several calls, as long as they take a twentieth of a second.
double prediction_seconds(const Regressor& model, const Matrix& x) {
  double least = std::numeric_limits<double>::infinity();
  double spent = 0.0;
  while (spent < 0.05) {
    const double seconds = seconds_of([&] { model.predict(x); });
    least = std::min(least, seconds);
    spent += seconds;
  }
  return least;
}

void print_table(const TrainingSet& data, const std::vector<Fold>& folds) {
  std::vector<std::size_t> fold_of_row(static_cast<std::size_t>(data.rows()));
  for (std::size_t f = 0; f < folds.size(); ++f)
    for (const Eigen::Index i : folds[f].test) fold_of_row[static_cast<std::size_t>(i)] = f;
  for (Eigen::Index i = 0; i < data.rows(); ++i) {
    fmt::print("{},{}", fold_of_row[static_cast<std::size_t>(i)], data.y[i]);
    for (Eigen::Index k = 0; k < data.dimension(); ++k) fmt::print(",{}", data.x(i, k));
    fmt::print("\n");
  }
}

void run(const TrainingSet& data, const std::vector<Fold>& folds, const Trainer& trainer,
         std::uint64_t seed) {
  for (const Fold& fold : folds) trainer.fit(selected_rows(data, fold.train), seed);  // warm up
  double fit_seconds = 0.0;
  double squares = 0.0;
  for (const Fold& fold : folds) {
    const TrainingSet train = selected_rows(data, fold.train);
    const TrainingSet test = selected_rows(data, fold.test);
    std::vector<Regressor> model;
    fit_seconds += seconds_of([&] { model.push_back(trainer.fit(train, seed)); });
    squares += (model.front().predict(test.x) - test.y).squaredNorm();
  }
  const Regressor model = trainer.fit(data, seed);
  Matrix many(10000, data.dimension());
  for (Eigen::Index i = 0; i < many.rows(); ++i) many.row(i) = data.x.row(i % data.rows());
  fmt::print("{{\"fit_seconds\": {}, \"rmse\": {}, \"predict_185\": {}, \"predict_10000\": {}}}\n",
             fit_seconds, std::sqrt(squares / static_cast<double>(data.rows())),
             prediction_seconds(model, data.x), prediction_seconds(model, many));
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  const bool table = words.size() == 3 && words[0] == "table";
  if (!table && !(words.size() == 4 && words[0] == "run")) {
    fmt::print(stderr, "repose_tree_peers table KIND SEED | run KIND SEED bag|boosting\n");
    return 2;
  }
  const auto seed = static_cast<std::uint64_t>(std::strtoull(words[2].c_str(), nullptr, 10));
  const TrainingSet data = table_of(words[1], seed);
  const std::vector<Fold> folds = folds_of(data, seed);
  if (table)
    print_table(data, folds);
  else
    run(data, folds, trainer_of(words[3]), seed);
  return 0;
}
