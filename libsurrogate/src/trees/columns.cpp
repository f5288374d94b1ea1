#include "columns.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace repose::surrogate::trees {
namespace {

/// Up to that many values, bins are filled and scanned; sorted rows beyond.
constexpr std::size_t kMostBins = 16;

}  // namespace

Columns::Columns(const Matrix& x, const std::vector<Input>& inputs) : x_(x) {
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    const Input& input = inputs[static_cast<std::size_t>(k)];
    scales_.push_back(input.scale);
    if ((x.col(k).array() == x(0, k)).all()) continue;
    if (input.is_categorical())
      add_category(k, static_cast<Count>(input.levels.size()));
    else
      add_number(k);
  }
  find_bins();
  in_order_.resize(size());
  std::iota(in_order_.begin(), in_order_.end(), std::size_t{0});
  std::sort(in_order_.begin(), in_order_.end(),
            [this](std::size_t a, std::size_t b) { return input_of(a) < input_of(b); });
}

void Columns::add_category(Eigen::Index input, Count levels) {
  binned_.push_back({.input = input, .categorical = true, .first_bin = bins_, .bins = levels});
  bins_ += levels;
}

void Columns::add_number(Eigen::Index input) {
  const double* x = values(input);
  std::vector<Count> order(rows());
  std::iota(order.begin(), order.end(), Count{0});
  std::sort(order.begin(), order.end(),
            [x](Count a, Count b) { return x[a] != x[b] ? x[a] < x[b] : a < b; });
  std::vector<double> distinct;
  for (const Count i : order) {
    if (distinct.empty() || x[i] != distinct.back()) distinct.push_back(x[i]);
    if (distinct.size() > kMostBins) {
      sorted_.push_back({input, std::move(order)});
      return;
    }
  }
  const auto bins = static_cast<Count>(distinct.size());
  binned_.push_back(
      {.input = input, .first_bin = bins_, .bins = bins, .values = std::move(distinct)});
  bins_ += bins;
}

void Columns::find_bins() {
  bin_of_.resize(rows() * binned_.size());
  for (std::size_t f = 0; f < binned_.size(); ++f) {
    const BinnedColumn& column = binned_[f];
    const double* x = values(column.input);
    for (Count i = 0; i < rows(); ++i) {
      const auto bin = column.categorical
                           ? static_cast<Count>(x[i])
                           : static_cast<Count>(std::lower_bound(column.values.begin(),
                                                                 column.values.end(), x[i]) -
                                                column.values.begin());
      bin_of_[i * binned_.size() + f] = column.first_bin + bin;
    }
  }
}

double Columns::threshold(Eigen::Index input, double a, double b) const {
  const bool log = scales_[static_cast<std::size_t>(input)] == Scale::log;
  const double middle = log ? std::sqrt(a) * std::sqrt(b) : 0.5 * a + 0.5 * b;
  return middle > a && middle <= b ? middle : b;  // neighbors: the middle rounds to a
}

}  // namespace repose::surrogate::trees
