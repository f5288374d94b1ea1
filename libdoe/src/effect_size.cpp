// Effect sizes.
#include "repose/doe/effect_size.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "columns.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void check_values(const char* what, const Vector& values) {
  if (values.size() < 2)
    throw InputError(fmt::format("{}: {} values; at least two are needed", what, values.size()));
  if (!values.allFinite()) throw InputError(fmt::format("{}: a value is not finite", what));
}

double sample_variance(const Vector& values) {
  return centred_ss(values) / static_cast<double>(values.size() - 1);
}

double pearson(const Vector& a, const Vector& b) {
  const double scale = std::sqrt(centred_ss(a)) * std::sqrt(centred_ss(b));
  const Vector da = a.array() - a.mean(), db = b.array() - b.mean();
  return scale > 0.0 ? std::clamp(da.dot(db) / scale, -1.0, 1.0) : kNaN;
}

/// Ranks from 1; values that are equal share the mean of theirs.
Vector ranks(const Vector& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::sort(order.begin(), order.end(), [&](auto i, auto j) { return values(i) < values(j); });
  Vector result(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t end = first;
    while (end < order.size() && values(order[end]) == values(order[first])) ++end;
    for (std::size_t i = first; i < end; ++i)
      result(order[i]) = 0.5 * static_cast<double>(first + 1 + end);
    first = end;
  }
  return result;
}

}  // namespace

double cohens_d(const Vector& a, const Vector& b) {
  check_values("Cohen's d", a);
  check_values("Cohen's d", b);
  return (a.mean() - b.mean()) / std::sqrt(0.5 * (sample_variance(a) + sample_variance(b)));
}

CoefficientOfVariation coefficient_of_variation(const Vector& values) {
  check_values("coefficient of variation", values);
  const double mean = std::abs(values.mean()), ss = centred_ss(values);
  const auto n = static_cast<double>(values.size());
  return {std::sqrt(ss / (n - 1.0)) / mean, std::sqrt(ss / n) / mean};
}

Correlation correlation(const Vector& a, const Vector& b) {
  check_values("correlation", a);
  check_values("correlation", b);
  if (a.size() != b.size())
    throw InputError(
        fmt::format("correlation: {} values and {} values; one to one", a.size(), b.size()));
  Correlation result{pearson(a, b), kNaN, pearson(ranks(a), ranks(b))};
  const auto df = static_cast<double>(a.size() - 2);
  if (df > 0.0)
    result.p = t_two_sided(
        result.pearson * std::sqrt(df / ((1.0 - result.pearson) * (1.0 + result.pearson))), df);
  return result;
}

double c4(int n) {
  if (n < 2)
    throw InputError(
        fmt::format("c4: a standard deviation of {} values; at least two are needed", n));
  return std::sqrt(2.0 / (n - 1.0)) * std::exp(std::lgamma(0.5 * n) - std::lgamma(0.5 * (n - 1.0)));
}

SignalToRepetition signal_to_repetition(const Matrix& values) {
  if (values.array().isInf().any())
    throw InputError("signal to repetition: a value is infinite; mark failed runs as NaN");
  std::vector<double> means, deviations;
  int repetitions = 0;
  bool equal = true;
  for (Eigen::Index run = 0; run < values.rows(); ++run) {
    std::vector<double> present;
    for (Eigen::Index r = 0; r < values.cols(); ++r)
      if (!std::isnan(values(run, r))) present.push_back(values(run, r));
    const auto count = static_cast<int>(present.size());
    if (count < 2) continue;
    equal = equal && (repetitions == 0 || repetitions == count);
    repetitions = count;
    const Eigen::Map<const Vector> v(present.data(), count);
    means.push_back(v.mean());
    deviations.push_back(std::sqrt(sample_variance(v)));
  }
  if (means.size() < 2)
    throw InputError(
        fmt::format("signal to repetition: {} runs have two values or more; at least two such runs "
                    "are needed",
                    means.size()));
  const auto runs = static_cast<Eigen::Index>(means.size());
  return {std::sqrt(sample_variance(Eigen::Map<const Vector>(means.data(), runs))) /
              Eigen::Map<const Vector>(deviations.data(), runs).mean(),
          equal ? 1.0 / (std::sqrt(static_cast<double>(repetitions)) * c4(repetitions)) : kNaN};
}

}  // namespace repose::doe
