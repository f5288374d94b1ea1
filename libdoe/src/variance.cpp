// One-way analysis of variance of runs with repetitions.
#include "repose/doe/variance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The values of each run that has any, missing ones left out, less the first value of all.
std::vector<std::vector<double>> shifted_groups(const Matrix& values) {
  std::vector<std::vector<double>> groups;
  double origin = kNaN;
  for (Eigen::Index run = 0; run < values.rows(); ++run) {
    std::vector<double> group;
    for (Eigen::Index repetition = 0; repetition < values.cols(); ++repetition) {
      const double value = values(run, repetition);
      if (std::isnan(value)) continue;
      if (std::isinf(value))
        throw InputError(fmt::format("variance decomposition: run {}, repetition {} is infinite",
                                     run + 1, repetition + 1));
      if (std::isnan(origin)) origin = value;
      group.push_back(value - origin);
    }
    if (!group.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

/// A sum with its rounding errors carried along [Neumaier1974].
class Sum {
 public:
  void add(double value) {
    const double next = sum_ + value;
    lost_ += std::abs(sum_) >= std::abs(value) ? (sum_ - next) + value : (value - next) + sum_;
    sum_ = next;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0, lost_ = 0.0;
};

double mean(const std::vector<double>& values) {
  Sum sum;
  for (const double value : values) sum.add(value);
  return sum.value() / static_cast<double>(values.size());
}

}  // namespace

VarianceDecomposition decompose_variance(const Matrix& values) {
  const std::vector<std::vector<double>> groups = shifted_groups(values);
  if (groups.size() < 2)
    throw InputError(fmt::format(
        "variance decomposition: {} runs with values; at least 2 are needed", groups.size()));
  std::vector<double> all;
  double sum_of_squared_sizes = 0.0;
  for (const std::vector<double>& group : groups) {
    all.insert(all.end(), group.begin(), group.end());
    sum_of_squared_sizes += static_cast<double>(group.size()) * static_cast<double>(group.size());
  }
  const double grand_mean = mean(all);

  VarianceDecomposition v;
  v.runs = static_cast<int>(groups.size());
  v.observations = static_cast<int>(all.size());
  Sum between, within;
  for (const std::vector<double>& group : groups) {
    const double group_mean = mean(group);
    const double deviation = group_mean - grand_mean;
    between.add(static_cast<double>(group.size()) * deviation * deviation);
    for (const double value : group) within.add((value - group_mean) * (value - group_mean));
  }
  v.between_ss = between.value();
  v.within_ss = within.value();
  const double total = v.between_ss + v.within_ss;
  v.parameter_share = total > 0.0 ? v.between_ss / total : kNaN;
  v.stochastic_share = total > 0.0 ? v.within_ss / total : kNaN;
  const int between_df = v.runs - 1, within_df = v.observations - v.runs;
  v.noise_floor = static_cast<double>(between_df) / (v.observations - 1);
  v.within_ms = v.unbiased_variance = v.unbiased_share = v.f = v.p_value = kNaN;
  if (within_df == 0) return v;

  v.within_ms = v.within_ss / within_df;
  const double between_ms = v.between_ss / between_df;
  const double repetitions = (v.observations - sum_of_squared_sizes / v.observations) / between_df;
  v.unbiased_variance = (between_ms - v.within_ms) / repetitions;
  if (total > 0.0)
    v.unbiased_share =
        std::max(0.0, v.unbiased_variance) / (std::max(0.0, v.unbiased_variance) + v.within_ms);
  v.f = between_ms / v.within_ms;
  v.p_value = f_upper_tail(v.f, between_df, within_df);
  return v;
}

}  // namespace repose::doe
