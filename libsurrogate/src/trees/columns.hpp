// Inputs arranged for the search of splits, once for all trees of an ensemble.
#pragma once

#include <cstdint>
#include <vector>

#include "repose/surrogate/input.hpp"

namespace repose::surrogate::trees {

/// Numbers of rows, bins and nodes.
using Count = std::uint32_t;

/// A category, or a number with few different values: rows fall into bins, one a level.
struct BinnedColumn {
  Eigen::Index input = 0;
  bool categorical = false;
  Count first_bin = 0;  ///< of all bins of all columns
  Count bins = 0;
  std::vector<double> values = {};  ///< of a number's bins, ascending
};

/// A number with many different values: rows in ascending order.
struct SortedColumn {
  Eigen::Index input = 0;
  std::vector<Count> order = {};  ///< of rows; equal values by row
};

/// n rows; inputs that are the same in all rows are left out.
class Columns {
 public:
  Columns(const Matrix& x, const std::vector<Input>& inputs);

  Count rows() const { return static_cast<Count>(x_.rows()); }
  Eigen::Index inputs() const { return x_.cols(); }
  const std::vector<BinnedColumn>& binned() const { return binned_; }
  const std::vector<SortedColumn>& sorted() const { return sorted_; }
  /// Of binned and sorted ones; they are numbered in this order.
  std::size_t size() const { return binned_.size() + sorted_.size(); }
  bool is_binned(std::size_t column) const { return column < binned_.size(); }
  Eigen::Index input_of(std::size_t column) const {
    return is_binned(column) ? binned_[column].input : sorted_[column - binned_.size()].input;
  }
  /// Their numbers in order of the inputs.
  const std::vector<std::size_t>& in_order() const { return in_order_; }
  Count bins() const { return bins_; }
  /// The bins of a row, one for each binned column.
  const Count* bins_of(Count row) const { return bin_of_.data() + row * binned_.size(); }
  const double* values(Eigen::Index input) const { return x_.col(input).data(); }
  /// Where to divide a < b, so that a is below it and b is not.
  double threshold(Eigen::Index input, double a, double b) const;

 private:
  void add_category(Eigen::Index input, Count levels);
  void add_number(Eigen::Index input);
  void find_bins();

  Matrix x_;
  std::vector<Scale> scales_;
  std::vector<BinnedColumn> binned_;
  std::vector<SortedColumn> sorted_;
  std::vector<std::size_t> in_order_;
  std::vector<Count> bin_of_;
  Count bins_ = 0;
};

}  // namespace repose::surrogate::trees
