#include "dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

/// Two observations of a deterministic function at one point may differ by rounding only.
constexpr double kSameValue = 1e-9;

void check(const Matrix& x, const Vector& y, const opt::Bounds& declared) {
  opt::check_bounds(declared);
  if (x.rows() != y.size())
    throw InputError(fmt::format("{} rows of inputs for {} responses; there must be one for each",
                                 x.rows(), y.size()));
  if (x.rows() == 0) throw InputError("no rows to fit a model to");
  if (x.cols() != declared.lower.size())
    throw InputError(fmt::format("inputs have {} columns but {} declared ranges", x.cols(),
                                 declared.lower.size()));
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    if (!(declared.lower[k] < declared.upper[k]))
      throw InputError(
          fmt::format("the declared range of input {} is [{}, {}]; it must not be empty", k + 1,
                      declared.lower[k], declared.upper[k]));
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      if (!std::isfinite(x(i, k)))
        throw InputError(
            fmt::format("row {}, input {} is {}; it must be finite: drop or repair the row", i + 1,
                        k + 1, x(i, k)));
    if (!std::isfinite(y[i]))
      throw InputError(fmt::format(
          "row {}, response is {}; it must be finite: drop or repair the row", i + 1, y[i]));
  }
}

/// Rows in lexicographic order of (x, y).
std::vector<Eigen::Index> sorted_rows(const Matrix& x, const Vector& y) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(x.rows()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      if (x(a, k) != x(b, k)) return x(a, k) < x(b, k);
    return y[a] != y[b] ? y[a] < y[b] : a < b;
  });
  return order;
}

/// Centre and spread of y: with a constant in the basis its mean and standard deviation, else about
/// 0. A spread within rounding counts as none and scales by 1.
void standardise(Dataset& data, const Vector& y, const std::vector<Eigen::Index>& order,
                 Basis basis) {
  const auto n = static_cast<double>(order.size());
  double largest = 0.0;
  double sum = 0.0;
  for (const Eigen::Index i : order) {
    largest = std::max(largest, std::abs(y[i]));
    sum += y[i];
  }
  if (largest == 0.0) return;
  if (basis != Basis::none) data.shift = sum / n;
  double squares = 0.0;  // relative to the largest value: no overflow
  for (const Eigen::Index i : order) squares += std::pow((y[i] - data.shift) / largest, 2);
  const double spread = std::sqrt(squares / n);
  if (spread > 8.0 * std::numeric_limits<double>::epsilon()) data.scale = spread * largest;
}

[[noreturn]] void refuse_differing_repeats(Eigen::Index a, Eigen::Index b) {
  throw InputError(fmt::format(
      "rows {} and {} have the same inputs but different responses; a model without noise "
      "cannot have both: estimate the noise",
      std::min(a, b) + 1, std::max(a, b) + 1));
}

}  // namespace

Matrix Dataset::to_unit(const Matrix& natural) const {
  Matrix unit = natural;
  for (Eigen::Index k = 0; k < unit.cols(); ++k)
    unit.col(k) =
        (natural.col(k).array() - declared.lower[k]) / (declared.upper[k] - declared.lower[k]);
  return unit;
}

Eigen::Index Dataset::find(const Vector& unit) const {
  for (Eigen::Index i = 0; i < points(); ++i)
    if (x.row(i).transpose() == unit) return i;
  return -1;
}

Dataset make_dataset(const Matrix& x, const Vector& y, const opt::Bounds& declared, Basis basis,
                     Noise noise) {
  check(x, y, declared);
  Dataset data;
  data.declared = declared;
  const std::vector<Eigen::Index> order = sorted_rows(x, y);
  standardise(data, y, order, basis);

  const Matrix unit = data.to_unit(x);
  std::vector<Eigen::Index> first;  // a row of each point
  std::vector<std::vector<double>> values;
  data.point_of_row.resize(order.size());
  data.value_of_row.resize(order.size());
  for (const Eigen::Index i : order) {
    const double value = (y[i] - data.shift) / data.scale;
    if (first.empty() || unit.row(first.back()) != unit.row(i)) {
      first.push_back(i);
      values.emplace_back();
    }
    if (noise == Noise::none && !values.back().empty() &&
        std::abs(value - values.back().front()) > kSameValue)
      refuse_differing_repeats(first.back(), i);
    values.back().push_back(value);
    data.point_of_row[static_cast<std::size_t>(i)] = static_cast<Eigen::Index>(first.size()) - 1;
    data.value_of_row[static_cast<std::size_t>(i)] = value;
  }
  data.x = unit(first, Eigen::all);
  data.y.resize(data.x.rows());
  data.count.resize(data.x.rows());
  for (Eigen::Index i = 0; i < data.points(); ++i) {
    const std::vector<double>& at = values[static_cast<std::size_t>(i)];
    data.count[i] = static_cast<double>(at.size());
    data.y[i] = std::accumulate(at.begin(), at.end(), 0.0) / data.count[i];
    for (const double value : at) data.within += (value - data.y[i]) * (value - data.y[i]);
  }
  return data;
}

Dataset with_observation(const Dataset& data, const Vector& unit, double standardised,
                         Noise noise) {
  Dataset more = data;
  Eigen::Index i = data.find(unit);
  if (i >= 0) {
    const double difference = standardised - more.y[i];
    if (noise == Noise::none && std::abs(difference) > kSameValue)
      throw InputError(
          fmt::format("a model without noise knows another response ({}) at this point than {}",
                      data.shift + data.scale * more.y[i], data.shift + data.scale * standardised));
    const double r = more.count[i];
    more.within += difference * difference * r / (r + 1.0);
    more.y[i] += difference / (r + 1.0);
    more.count[i] = r + 1.0;
  } else {
    i = data.points();
    more.x.conservativeResize(i + 1, Eigen::NoChange);
    more.x.row(i) = unit;
    more.y.conservativeResize(i + 1);
    more.y[i] = standardised;
    more.count.conservativeResize(i + 1);
    more.count[i] = 1.0;
  }
  more.point_of_row.push_back(i);
  more.value_of_row.push_back(standardised);
  return more;
}

Eigen::Index basis_size(Basis basis) {
  return basis == Basis::constant ? 1 : 0;
}

Matrix basis_matrix(Basis basis, const Matrix& x) {
  return Matrix::Ones(x.rows(), basis_size(basis));
}

}  // namespace repose::surrogate
