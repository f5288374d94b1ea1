#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {
namespace {

using Index = Eigen::Index;

/// Numbers from 0 in order of the keys' first rows.
template <class Key>
std::vector<Index> renumbered(const std::vector<Key>& keys) {
  std::map<Key, Index> numbers;
  std::vector<Index> result;
  for (const Key& key : keys)
    result.push_back(numbers.try_emplace(key, static_cast<Index>(numbers.size())).first->second);
  return result;
}

Index count_of(const std::vector<Index>& numbers) {
  return *std::max_element(numbers.begin(), numbers.end()) + 1;
}

/// Folds of these rows, the fold of each row given.
std::vector<Fold> folds_of(const std::vector<Index>& fold_of_row, Index folds) {
  std::vector<Fold> result(static_cast<std::size_t>(folds));
  for (std::size_t i = 0; i < fold_of_row.size(); ++i)
    for (Index f = 0; f < folds; ++f) {
      Fold& fold = result[static_cast<std::size_t>(f)];
      (f == fold_of_row[i] ? fold.test : fold.train).push_back(static_cast<Index>(i));
    }
  return result;
}

/// Points in a random order, the large ones first, each into the fold with the fewest rows yet.
std::vector<Index> divided(const std::vector<Index>& point_of_row, Index folds,
                           RandomStream& random) {
  std::vector<Index> order(static_cast<std::size_t>(count_of(point_of_row)));
  std::vector<Index> rows(order.size(), 0);
  std::iota(order.begin(), order.end(), Index{0});
  for (const Index point : point_of_row) ++rows[static_cast<std::size_t>(point)];
  random.shuffle(order);
  std::stable_sort(order.begin(), order.end(), [&rows](Index a, Index b) {
    return rows[static_cast<std::size_t>(a)] > rows[static_cast<std::size_t>(b)];
  });
  std::vector<Index> filled(static_cast<std::size_t>(folds), 0);
  std::vector<Index> fold_of_point(order.size());
  for (const Index point : order) {
    const auto emptiest = std::min_element(filled.begin(), filled.end());
    *emptiest += rows[static_cast<std::size_t>(point)];
    fold_of_point[static_cast<std::size_t>(point)] = emptiest - filled.begin();
  }
  std::vector<Index> fold_of_row;
  for (const Index point : point_of_row)
    fold_of_row.push_back(fold_of_point[static_cast<std::size_t>(point)]);
  return fold_of_row;
}

}  // namespace

std::vector<Index> points_of(const TrainingSet& data) {
  if (!data.replicates.empty()) return renumbered(data.replicates);
  std::vector<std::vector<double>> keys;
  for (Index i = 0; i < data.rows(); ++i) {
    const Vector row = data.x.row(i);
    keys.emplace_back(row.begin(), row.end());
  }
  return renumbered(keys);
}

Index number_of_points(const TrainingSet& data) {
  return data.rows() == 0 ? 0 : count_of(points_of(data));
}

std::vector<Fold> k_folds(const TrainingSet& data, const KFoldOptions& options) {
  check(data);
  const std::vector<Index> point_of_row = points_of(data);
  const Index points = count_of(point_of_row);
  if (options.folds < 2 || options.folds > points)
    throw InputError(fmt::format(
        "{} folds of {} different points ({} rows); there must be at least 2 and no more than "
        "that, repeats of a point staying together",
        options.folds, points, data.rows()));
  if (options.repetitions < 1)
    throw InputError(fmt::format("{} repetitions of cross-validation; there must be at least 1",
                                 options.repetitions));
  std::vector<Fold> all;
  for (int r = 0; r < options.repetitions; ++r) {
    RandomStream random(options.seed, static_cast<std::uint64_t>(r));
    auto folds = folds_of(divided(point_of_row, options.folds, random), options.folds);
    for (std::size_t f = 0; f < folds.size(); ++f) {
      folds[f].name = options.repetitions == 1
                          ? fmt::format("fold {}", f + 1)
                          : fmt::format("repetition {}, fold {}", r + 1, f + 1);
      folds[f].repetition = r;
      all.push_back(std::move(folds[f]));
    }
  }
  return all;
}

std::vector<Fold> leave_group_out(const TrainingSet& data, const std::vector<std::string>& names) {
  check(data);
  if (data.groups.empty())
    throw InputError("leaving groups out needs the group of each row; none are given");
  std::vector<Index> numbers = data.groups;
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  if (numbers.size() < 2)
    throw InputError(
        "all rows belong to one group; leaving a group out needs at least two: take k folds "
        "instead");
  std::vector<Index> fold_of_row;
  for (const Index group : data.groups)
    fold_of_row.push_back(std::lower_bound(numbers.begin(), numbers.end(), group) -
                          numbers.begin());
  auto folds = folds_of(fold_of_row, static_cast<Index>(numbers.size()));
  for (std::size_t f = 0; f < folds.size(); ++f) {
    const auto number = static_cast<std::size_t>(numbers[f]);
    folds[f].name = number < names.size() ? names[number] : fmt::format("group {}", numbers[f]);
  }
  return folds;
}

}  // namespace repose::surrogate
