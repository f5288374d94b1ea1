#include "dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "repose/base/error.hpp"
#include "response.hpp"

namespace repose::surrogate {
namespace {

/// Two observations of a deterministic function at one point may differ by rounding only.
constexpr double kSameValue = 1e-9;

void check_shape(const Matrix& x, const Vector& y, const Encoding& encoding,
                 const GaussianProcessOptions& options) {
  if (x.rows() != y.size())
    throw InputError(fmt::format("{} rows of inputs for {} responses; there must be one for each",
                                 x.rows(), y.size()));
  if (x.rows() == 0) throw InputError("no rows to fit a model to");
  if (x.cols() != encoding.dimension())
    throw InputError(fmt::format("inputs have {} columns but {} declared ranges", x.cols(),
                                 encoding.dimension()));
  const bool known = options.noise == Noise::known;
  if (options.noise_variances.size() != (known ? y.size() : 0))
    throw InputError(
        fmt::format("{} noise variances for {} rows; Noise::known takes one for each, others none",
                    options.noise_variances.size(), y.size()));
  if (!options.functions.names.empty() && !options.functions.evaluate)
    throw InputError("regression functions have names but nothing that evaluates them");
}

/// y on the scale it is modelled on.
Vector modelled_rows(const Vector& y, ResponseScale scale, double& jacobian) {
  Vector g(y.size());
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    if (!std::isfinite(y[i]))
      throw InputError(fmt::format(
          "row {}, response is {}; it must be finite: drop or repair the row", i + 1, y[i]));
    g[i] = modelled(scale, y[i]);
    if (!std::isfinite(g[i]))
      throw InputError(fmt::format("row {}, response is {}; on a {} scale it must be {}", i + 1,
                                   y[i], to_string(scale),
                                   scale == ResponseScale::log ? "positive" : "between 0 and 1"));
    jacobian += log_jacobian(scale, y[i]);
  }
  return g;
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
void standardise(Dataset& data, const Vector& y, const std::vector<Eigen::Index>& order) {
  const auto n = static_cast<double>(order.size());
  double largest = 0.0;
  double sum = 0.0;
  for (const Eigen::Index i : order) {
    largest = std::max(largest, std::abs(y[i]));
    sum += y[i];
  }
  if (largest == 0.0) return;
  if (data.trend.has_constant()) data.shift = sum / n;
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

/// Points and which of them each row belongs to.
void find_points(Dataset& data, const Matrix& x, const Matrix& encoded,
                 const std::vector<Eigen::Index>& order, Noise noise) {
  std::vector<Eigen::Index> first;  // a row of each point
  data.point_of_row.resize(order.size());
  for (const Eigen::Index i : order) {
    const auto row = static_cast<std::size_t>(i);
    if (first.empty() || encoded.row(first.back()) != encoded.row(i)) first.push_back(i);
    if (noise == Noise::none &&
        std::abs(data.value_of_row[row] -
                 data.value_of_row[static_cast<std::size_t>(first.back())]) > kSameValue)
      refuse_differing_repeats(first.back(), i);
    data.point_of_row[row] = static_cast<Eigen::Index>(first.size()) - 1;
  }
  data.natural = x(first, Eigen::all);
  data.x = encoded(first, Eigen::all);
}

/// Relative noise variances, from what is known of y on its own scale: that of g(y) is g'(y)^2 as
/// large, to first order.
void set_known_noise(Dataset& data, const Vector& y, const Vector& variances) {
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    if (!(variances[i] > 0.0) || !std::isfinite(variances[i]))
      throw InputError(fmt::format(
          "row {}, noise variance is {}; it must be positive and finite (Noise::none is exact)",
          i + 1, variances[i]));
    data.noise_of_row[static_cast<std::size_t>(i)] =
        variances[i] * std::exp(2.0 * log_jacobian(data.response_scale, y[i])) /
        (data.scale * data.scale);
  }
}

/// s~^2 = (w s0^2 + (r-1) s^2)/(w + r-1) for the observations of each point, from sums of squares
/// about plain means.
void set_noise_by_point(Dataset& data, double pooled_weight) {
  if (!(pooled_weight > 0.0))
    throw InputError(fmt::format("pooled_weight is {}; it must be positive", pooled_weight));
  aggregate(data);
  Vector squares = Vector::Zero(data.points());
  Vector freedom = Vector::Constant(data.points(), -1.0);
  for (std::size_t j = 0; j < data.value_of_row.size(); ++j) {
    const Eigen::Index i = data.point_of_row[j];
    squares[i] += std::pow(data.value_of_row[j] - data.y[i], 2);
    freedom[i] += 1.0;
  }
  if (!(squares.sum() > 0.0))
    throw InputError(
        "noise by point needs repeats that differ; there are none: choose estimated or known "
        "noise");
  const double pooled = squares.sum() / freedom.sum();
  for (std::size_t j = 0; j < data.value_of_row.size(); ++j) {
    const Eigen::Index i = data.point_of_row[j];
    data.noise_of_row[j] = (pooled_weight * pooled + squares[i]) / (pooled_weight + freedom[i]);
  }
}

}  // namespace

double Dataset::mean_noise() const {
  double sum = 0.0;
  for (const double w : noise_of_row) sum += w;
  return sum / static_cast<double>(noise_of_row.size());
}

double Dataset::modelled_value(double response) const {
  return modelled(response_scale, response);
}

Eigen::Index Dataset::find(const Vector& encoded) const {
  for (Eigen::Index i = 0; i < points(); ++i)
    if (x.row(i).transpose() == encoded) return i;
  return -1;
}

void aggregate(Dataset& data) {
  const Eigen::Index n = data.points();
  Vector precision = Vector::Zero(n);
  data.y = Vector::Zero(n);
  data.log_repeats = 0.0;
  std::vector<std::size_t> order(data.value_of_row.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {  // of any order of rows
    if (data.point_of_row[a] != data.point_of_row[b])
      return data.point_of_row[a] < data.point_of_row[b];
    return data.value_of_row[a] != data.value_of_row[b]
               ? data.value_of_row[a] < data.value_of_row[b]
               : data.noise_of_row[a] < data.noise_of_row[b];
  });
  for (const std::size_t j : order) {
    const Eigen::Index i = data.point_of_row[j];
    precision[i] += 1.0 / data.noise_of_row[j];
    data.y[i] += data.value_of_row[j] / data.noise_of_row[j];
    data.log_repeats += std::log(data.noise_of_row[j]);
  }
  data.noise = precision.cwiseInverse();
  data.y.array() *= data.noise.array();
  data.log_repeats -= data.noise.array().log().sum();
  data.within = 0.0;
  for (const std::size_t j : order) {
    const double difference = data.value_of_row[j] - data.y[data.point_of_row[j]];
    data.within += difference * difference / data.noise_of_row[j];
  }
}

Dataset make_dataset(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                     const GaussianProcessOptions& options) {
  Dataset data;
  data.encoding = Encoding(inputs, options.kernel.length_scales);
  data.trend = {options.basis, options.functions};
  data.response_scale = options.response_scale;
  check_shape(x, y, data.encoding, options);
  const Matrix encoded = data.encoding.encode(x);
  const Vector g = modelled_rows(y, options.response_scale, data.log_jacobian);
  const std::vector<Eigen::Index> order = sorted_rows(x, g);
  standardise(data, g, order);
  for (const double value : g) data.value_of_row.push_back((value - data.shift) / data.scale);
  data.noise_of_row.assign(data.value_of_row.size(), 1.0);
  find_points(data, x, encoded, order, options.noise);
  if (options.noise == Noise::known) set_known_noise(data, y, options.noise_variances);
  if (options.noise == Noise::by_point) set_noise_by_point(data, options.pooled_weight);
  aggregate(data);
  data.h = trend_matrix(data.trend, data.encoding, data.natural, data.x);
  return data;
}

Dataset with_observation(const Dataset& data, const Vector& natural, double y, Noise noise) {
  Dataset more = data;
  const double value = data.standardised(y);
  if (!std::isfinite(value))
    throw InputError(fmt::format("a response of {} cannot be modelled on a {} scale", y,
                                 to_string(data.response_scale)));
  const Matrix encoded = data.encoding.encode(natural.transpose());
  Eigen::Index i = data.find(encoded.row(0));
  const double w = data.mean_noise();
  if (i >= 0) {
    const double difference = value - more.y[i];
    if (noise == Noise::none && std::abs(difference) > kSameValue)
      throw InputError(
          fmt::format("a model without noise knows another response at this point than {}", y));
    const double v = more.noise[i];
    more.noise[i] = 1.0 / (1.0 / v + 1.0 / w);
    more.y[i] += difference * v / (v + w);
    more.within += difference * difference / (v + w);
    more.log_repeats += std::log(w) + std::log(v) - std::log(more.noise[i]);
  } else {
    i = data.points();
    const auto append = [i](Matrix& m, const auto& row) {
      m.conservativeResize(i + 1, Eigen::NoChange);
      m.row(i) = row;
    };
    append(more.natural, natural.transpose());
    append(more.x, encoded);
    append(more.h, trend_matrix(data.trend, data.encoding, natural.transpose(), encoded));
    more.y.conservativeResize(i + 1);
    more.y[i] = value;
    more.noise.conservativeResize(i + 1);
    more.noise[i] = w;
  }
  more.log_jacobian += log_jacobian(data.response_scale, y);
  more.point_of_row.push_back(i);
  more.value_of_row.push_back(value);
  more.noise_of_row.push_back(w);
  return more;
}

}  // namespace repose::surrogate
