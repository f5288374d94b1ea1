// Linear constraints and whole numbers.
#include "repose/opt/feasible_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

std::string name_of(const FeasibleSet& set, std::size_t i) {
  return set.inequalities[i].name.empty() ? fmt::format("constraint {}", i + 1)
                                          : "constraint " + set.inequalities[i].name;
}

/// sum |a_k| (upper_k - lower_k): how much a . x varies over the box.
double range_of(const LinearInequality& inequality, const Bounds& bounds) {
  return inequality.coefficients.cwiseAbs().dot(bounds.upper - bounds.lower);
}

}  // namespace

void check_feasible_set(const FeasibleSet& set) {
  check_bounds(set.bounds);
  const Eigen::Index d = set.bounds.lower.size();
  for (const Eigen::Index k : set.whole) {
    if (k < 0 || k >= d)
      throw InputError(
          fmt::format("coordinate {} is to be a whole number; there are {}", k + 1, d));
    if (std::ceil(set.bounds.lower[k]) > std::floor(set.bounds.upper[k]))
      throw InputError(fmt::format("coordinate {} lies in [{}, {}], which holds no whole number",
                                   k + 1, set.bounds.lower[k], set.bounds.upper[k]));
  }
  for (std::size_t i = 0; i < set.inequalities.size(); ++i) {
    const LinearInequality& inequality = set.inequalities[i];
    const Vector& a = inequality.coefficients;
    if (a.size() != d || !a.allFinite() || !std::isfinite(inequality.bound))
      throw InputError(
          fmt::format("{} has {} coefficients; {} finite ones and a finite bound are "
                      "needed",
                      name_of(set, i), a.size(), d));
    const double least =
        (a.array() > 0.0).select(set.bounds.lower, set.bounds.upper).cwiseProduct(a).sum();
    if (least > inequality.bound + 1e-12 * range_of(inequality, set.bounds))
      throw InputError(fmt::format("{}: no point of the box is below {}; the smallest value is {}",
                                   name_of(set, i), inequality.bound, least));
  }
}

Vector rounded(const Vector& x, const FeasibleSet& set) {
  Vector result = project(x, set.bounds);
  for (const Eigen::Index k : set.whole)
    result[k] = std::clamp(std::round(result[k]), std::ceil(set.bounds.lower[k]),
                           std::floor(set.bounds.upper[k]));
  return result;
}

double violation(const Vector& x, const FeasibleSet& set) {
  double sum = 0.0;
  for (const LinearInequality& inequality : set.inequalities) {
    const double excess = inequality.coefficients.dot(x) - inequality.bound;
    const double size =
        inequality.coefficients.cwiseAbs().dot(x.cwiseAbs()) + std::abs(inequality.bound);
    if (excess > 1e-12 * size) sum += excess / std::max(range_of(inequality, set.bounds), 1e-300);
  }
  return sum;
}

}  // namespace repose::opt
