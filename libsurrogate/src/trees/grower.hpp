// Grows one tree after another over the same inputs; nothing is allocated between two of them.
#pragma once

#include <span>
#include <vector>

#include "columns.hpp"
#include "forest.hpp"
#include "repose/base/random.hpp"

namespace repose::surrogate::trees {

/// TreeOptions made definite for some data.
struct Limits {
  Count minimum_leaf = 1;
  Count maximum_splits = 0;
  Count maximum_depth = 0;
  std::size_t predictors = 0;  ///< of Columns::size(); equal: all, none drawn
};

/// Of some rows. How often they count is a whole number, their weight need not be.
struct Sums {
  double weight = 0.0;
  double response = 0.0;  ///< weighted
  double count = 0.0;
  Sums& operator+=(const Sums& other) {
    weight += other.weight;
    response += other.response;
    count += other.count;
    return *this;
  }
  double rows() const { return count; }
};

/// The same where all weights are 1, so that rows count what they weigh: two thirds of the traffic.
struct UnitSums {
  double weight = 0.0;
  double response = 0.0;
  UnitSums& operator+=(const UnitSums& other) {
    weight += other.weight;
    response += other.response;
    return *this;
  }
  double rows() const { return weight; }
};

/// S: Sums or UnitSums.
template <class S>
class Grower {
 public:
  Grower(const Columns& columns, const Limits& limits);

  /// Rows with a count of 0 are left out. `random` draws predictors.
  void grow(std::span<const double> response, std::span<const double> weight,
            std::span<const Count> count, RandomStream& random);

  bool has_split() const { return depth_ > 0; }
  /// The tree, of means of the responses.
  Forest forest() const;
  /// Calls visit(rows, mean) for each leaf.
  template <class Visit>
  void for_each_leaf(Visit visit) const {
    for (const Growing& node : nodes_)
      if (node.left == 0)
        visit(std::span(rows_).subspan(node.begin, node.end - node.begin), mean(node));
  }

 private:
  struct Split {
    double gain = 0.0;       ///< of the sum of squares about the means; 0: none
    std::size_t column = 0;  ///< of Columns
    double below = 0.0;      ///< largest value of a number that goes left ...
    double above = 0.0;      ///< ... and the smallest of those that do not
    std::size_t levels = 0;  ///< of a category: first of its flags in level_sets_
  };
  struct Growing {
    Count begin = 0;  ///< of rows_
    Count end = 0;
    S sums = {};
    Count left = 0;  ///< 0: a leaf
    Split split = {};
  };

  void start(std::span<const double> response, std::span<const double> weight,
             std::span<const Count> count);
  bool may_split(const Growing& node) const;
  Split find_split(const Growing& node, RandomStream& random);
  void search(const Growing& node, std::span<const std::size_t> columns, Split& best);
  void search_pair(const Growing& node, std::span<const std::size_t> columns, Split& best);
  void fill_bins(const Growing& node, std::span<const std::size_t> columns);
  void search_number(const S& total, std::size_t column, Split& best) const;
  Split division_after(const BinnedColumn& c, Count bin, std::size_t column, double gain) const;
  void search_category(const S& total, std::size_t column, Split& best);
  void search_sorted(const Growing& node, std::size_t column, Split& best) const;
  void keep_largest(std::size_t first, Count kept);
  void divide(std::size_t parent, bool grows_on);
  Growing node_of(Count begin, Count end) const;
  double mean(const Growing& node) const { return centre_ + node.sums.response / node.sums.weight; }

  const Columns& columns_;
  Limits limits_;
  std::vector<S> of_row_;
  std::vector<Growing> nodes_;  // layer by layer
  Count depth_ = 0;
  std::vector<Count> rows_;                 // each node's together
  std::vector<std::vector<Count>> sorted_;  // the same in order of each sorted column
  std::vector<std::uint8_t> level_sets_;
  double centre_ = 0.0;  // mean of all responses, taken off for accuracy
  double noise_ = 0.0;   // gains up to that are rounding

  // scratch
  std::vector<S> bins_;
  std::vector<std::size_t> draw_;
  std::vector<std::size_t> drawn_binned_;
  std::vector<std::uint8_t> left_of_row_;
  std::vector<Count> moved_;
  std::vector<std::uint8_t> left_levels_;
  std::vector<std::pair<double, Count>> level_means_;
};

extern template class Grower<Sums>;
extern template class Grower<UnitSums>;

}  // namespace repose::surrogate::trees
