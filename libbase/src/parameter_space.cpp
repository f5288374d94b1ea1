#include "repose/base/parameter_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose {
namespace {

constexpr double kLargestInteger = 1e9;  // neighbours stay apart after a logarithm and back

void check_levels(const Parameter& p) {
  if (p.levels.size() < 2)
    throw InputError(fmt::format("parameter {}: {} levels; two or more are needed, or fix it",
                                 p.name, p.levels.size()));
  for (std::size_t i = 0; i < p.levels.size(); ++i)
    if (!std::isfinite(p.levels[i]) || (i > 0 && p.levels[i] <= p.levels[i - 1]))
      throw InputError(fmt::format("parameter {}: level {} is {}; levels must be finite and ascend",
                                   p.name, i + 1, shortest(p.levels[i])));
}

void check_categories(const Parameter& p) {
  const std::set<std::string> different(p.categories.begin(), p.categories.end());
  if (p.categories.size() < 2 || different.size() != p.categories.size() || different.count(""))
    throw InputError(
        fmt::format("parameter {}: categories {}; there must be two or more different names",
                    p.name, p.categories.empty() ? "none" : listed(p.categories)));
}

/// The range that follows from levels and categories.
Parameter with_range(Parameter p) {
  if (p.name.empty()) throw InputError("a parameter has an empty name; give it one");
  if (p.kind == ParameterKind::levels) {
    check_levels(p);
    p.lower = p.levels.front();
    p.upper = p.levels.back();
  } else if (p.kind == ParameterKind::categorical) {
    check_categories(p);
    p.lower = 0.0;
    p.upper = static_cast<double>(p.categories.size() - 1);
  }
  return p;
}

void check_range(const Parameter& p) {
  if (!std::isfinite(p.lower) || !std::isfinite(p.upper) || p.lower >= p.upper)
    throw InputError(
        fmt::format("parameter {}: lower = {}, upper = {}: lower must be finite and below upper",
                    p.name, shortest(p.lower), shortest(p.upper)));
  if (p.scale == Scale::log && p.lower <= 0.0)
    throw InputError(
        fmt::format("parameter {}: lower = {} on a logarithmic scale: it must be above 0", p.name,
                    shortest(p.lower)));
  if (p.scale == Scale::log && p.kind == ParameterKind::categorical)
    throw InputError(fmt::format("parameter {}: names have no logarithmic scale", p.name));
  const auto whole = [](double v) { return v == std::floor(v) && std::abs(v) <= kLargestInteger; };
  if (p.kind == ParameterKind::integer && !(whole(p.lower) && whole(p.upper)))
    throw InputError(fmt::format(
        "parameter {}: lower = {}, upper = {}: the ends of whole numbers must be whole, at most "
        "1e9 in size",
        p.name, shortest(p.lower), shortest(p.upper)));
}

/// Ties in an order in which each one's sources are known before it.
std::vector<Tie> in_computable_order(std::vector<Tie> ties, std::set<std::string> known) {
  std::vector<Tie> ordered;
  while (!ties.empty()) {
    const auto ready = std::find_if(ties.begin(), ties.end(), [&](const Tie& tie) {
      return std::all_of(tie.sources.begin(), tie.sources.end(),
                         [&](const std::string& s) { return known.count(s) > 0; });
    });
    if (ready == ties.end()) {
      const Tie& tie = ties.front();
      const auto missing = std::find_if(tie.sources.begin(), tie.sources.end(),
                                        [&](const std::string& s) { return known.count(s) == 0; });
      throw InputError(
          fmt::format("tie {}: its source {} is neither a free, a fixed nor a computable tied "
                      "parameter; name one of {}",
                      tie.name, *missing, listed({known.begin(), known.end()})));
    }
    known.insert(ready->name);
    ordered.push_back(*ready);
    ties.erase(ready);
  }
  return ordered;
}

void check_constraint(const LinearConstraint& constraint, const std::set<std::string>& known,
                      const std::set<std::string>& names_only) {
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("constraint {}: {}", constraint.name, what));
  };
  bool any = false;
  for (const auto& [name, coefficient] : constraint.coefficients) {
    if (known.count(name) == 0)
      fail(fmt::format("{} is no parameter; there are {}", name,
                       listed({known.begin(), known.end()})));
    if (names_only.count(name) > 0)
      fail(fmt::format("{} has names instead of numbers and cannot be part of a sum", name));
    if (!std::isfinite(coefficient))
      fail(fmt::format("the coefficient of {} is {}; it must be finite", name, coefficient));
    any = any || coefficient != 0.0;
  }
  if (!any) fail("no coefficient differs from 0; give one at least");
  if (std::isnan(constraint.lower) || std::isnan(constraint.upper) ||
      constraint.lower > constraint.upper)
    fail(fmt::format("lower = {} and upper = {} leave nothing between them",
                     shortest(constraint.lower), shortest(constraint.upper)));
  if (std::isinf(constraint.lower) && std::isinf(constraint.upper))
    fail("it bounds nothing; give it a lower or an upper bound");
}

/// A sum of terms and how far rounding may carry it.
struct Sum {
  double value = 0.0, tolerance = 0.0;
};

Sum sum_of(const LinearConstraint& constraint, const ParameterValues& values) {
  Sum sum;
  for (const auto& [name, coefficient] : constraint.coefficients) {
    const double term = coefficient * values.at(name);
    sum.value += term;
    sum.tolerance += 1e-9 * std::abs(term);
  }
  return sum;
}

/// -1 below the lower bound, 1 above the upper one, else 0.
int side_of(const LinearConstraint& constraint, const Sum& sum) {
  if (sum.value < constraint.lower - sum.tolerance) return -1;
  return sum.value > constraint.upper + sum.tolerance ? 1 : 0;
}

std::string sum_text(const LinearConstraint& constraint) {
  std::string text;
  for (const auto& [name, coefficient] : constraint.coefficients)
    text += fmt::format("{}{} {}",
                        text.empty()        ? (coefficient < 0.0 ? "-" : "")
                        : coefficient < 0.0 ? " - "
                                            : " + ",
                        shortest(std::abs(coefficient)), name);
  return text;
}

std::size_t bin_of(double unit, std::size_t bins) {
  return std::min(bins - 1, static_cast<std::size_t>(unit * static_cast<double>(bins)));
}

double place_of_bin(std::size_t bin, std::size_t bins) {
  return static_cast<double>(bin) / static_cast<double>(bins - 1);
}

double integer_value(const Parameter& p, double unit) {
  if (p.scale == Scale::log)
    return std::floor(p.lower * std::exp(unit * std::log((p.upper + 1.0) / p.lower)));
  return p.lower + static_cast<double>(bin_of(unit, level_count(p)));
}

std::size_t nearest_level(const std::vector<double>& levels, double value) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < levels.size(); ++i)
    if (std::abs(levels[i] - value) < std::abs(levels[nearest] - value)) nearest = i;
  return nearest;
}

}  // namespace

std::size_t level_count(const Parameter& p) {
  switch (p.kind) {
    case ParameterKind::continuous:
      return 0;
    case ParameterKind::integer:
      return static_cast<std::size_t>(p.upper - p.lower) + 1;
    case ParameterKind::levels:
      return p.levels.size();
    case ParameterKind::categorical:
      return p.categories.size();
  }
  return 0;
}

double natural_value(const Parameter& p, double unit) {
  const double u = std::clamp(unit, 0.0, 1.0);
  double value = 0.0;
  switch (p.kind) {
    case ParameterKind::continuous:
      value = p.scale == Scale::log ? std::exp(std::log(p.lower) + u * std::log(p.upper / p.lower))
                                    : p.lower + u * (p.upper - p.lower);
      break;
    case ParameterKind::integer:
      value = integer_value(p, u);
      break;
    case ParameterKind::levels:
      return p.levels[bin_of(u, p.levels.size())];
    case ParameterKind::categorical:
      return static_cast<double>(bin_of(u, p.categories.size()));
  }
  return std::clamp(value, p.lower, p.upper);
}

double unit_value(const Parameter& p, double natural) {
  if (p.kind == ParameterKind::levels)
    return place_of_bin(nearest_level(p.levels, natural), p.levels.size());
  const double value = p.kind == ParameterKind::continuous ? natural : std::round(natural);
  return p.scale == Scale::log ? std::log(value / p.lower) / std::log(p.upper / p.lower)
                               : (value - p.lower) / (p.upper - p.lower);
}

ParameterSpace::ParameterSpace(std::vector<Parameter> free, ParameterValues fixed,
                               std::vector<Tie> ties, std::vector<LinearConstraint> constraints)
    : free_(std::move(free)), fixed_(std::move(fixed)), constraints_(std::move(constraints)) {
  std::set<std::string> all;
  std::set<std::string> known;
  std::set<std::string> names_only;
  const auto add = [&](const std::string& name) {
    if (!all.insert(name).second)
      throw InputError(fmt::format("parameter {} is given twice; keep one of the two", name));
  };
  for (auto& p : free_) {
    p = with_range(std::move(p));
    check_range(p);
    add(p.name);
    known.insert(p.name);
    if (p.kind == ParameterKind::categorical) names_only.insert(p.name);
  }
  for (const auto& [name, value] : fixed_) {
    if (!std::isfinite(value))
      throw InputError(fmt::format("parameter {} = {}: a fixed value must be finite", name, value));
    add(name);
    known.insert(name);
  }
  for (const auto& tie : ties) {
    if (tie.sources.empty())
      throw InputError(fmt::format("tie {} has no sources; name at least one", tie.name));
    for (const auto& source : tie.sources)
      if (names_only.count(source) > 0)
        throw InputError(
            fmt::format("tie {}: its source {} has names instead of numbers; a mean needs numbers",
                        tie.name, source));
    add(tie.name);
  }
  ties_ = in_computable_order(std::move(ties), std::move(known));
  for (const auto& constraint : constraints_) check_constraint(constraint, all, names_only);
}

std::vector<std::string> ParameterSpace::names() const {
  std::vector<std::string> names;
  for (const auto& p : free_) names.push_back(p.name);
  return names;
}

Vector ParameterSpace::from_unit(const Vector& unit) const {
  REPOSE_ASSERT(static_cast<std::size_t>(unit.size()) == dimension(),
                fmt::format("{}", unit.size()));
  Vector natural(unit.size());
  for (Eigen::Index i = 0; i < unit.size(); ++i)
    natural[i] = natural_value(free_[static_cast<std::size_t>(i)], unit[i]);
  return natural;
}

Vector ParameterSpace::to_unit(const Vector& natural) const {
  REPOSE_ASSERT(static_cast<std::size_t>(natural.size()) == dimension(),
                fmt::format("{}", natural.size()));
  Vector unit(natural.size());
  for (Eigen::Index i = 0; i < natural.size(); ++i)
    unit[i] = unit_value(free_[static_cast<std::size_t>(i)], natural[i]);
  return unit;
}

Matrix ParameterSpace::from_unit_rows(const Matrix& unit) const {
  Matrix natural(unit.rows(), unit.cols());
  for (Eigen::Index i = 0; i < unit.rows(); ++i)
    natural.row(i) = from_unit(unit.row(i).transpose()).transpose();
  return natural;
}

ParameterValues ParameterSpace::complete(const Vector& natural) const {
  REPOSE_ASSERT(static_cast<std::size_t>(natural.size()) == dimension(),
                fmt::format("{}", natural.size()));
  ParameterValues values = fixed_;
  for (std::size_t i = 0; i < free_.size(); ++i)
    values[free_[i].name] = natural[static_cast<Eigen::Index>(i)];
  for (const auto& tie : ties_) {
    double sum = 0.0;
    for (const auto& source : tie.sources) sum += values.at(source);
    values[tie.name] = sum / static_cast<double>(tie.sources.size());
  }
  return values;
}

bool ParameterSpace::obeys_constraints(const Vector& natural) const {
  if (constraints_.empty()) return true;
  const ParameterValues values = complete(natural);
  return std::all_of(constraints_.begin(), constraints_.end(), [&](const auto& constraint) {
    return side_of(constraint, sum_of(constraint, values)) == 0;
  });
}

std::vector<std::string> ParameterSpace::broken_constraints(const Vector& natural) const {
  const ParameterValues values = complete(natural);
  std::vector<std::string> broken;
  for (const auto& constraint : constraints_) {
    const Sum sum = sum_of(constraint, values);
    const int side = side_of(constraint, sum);
    if (side != 0)
      broken.push_back(fmt::format("{}: {} = {:.6g} is {} {}", constraint.name,
                                   sum_text(constraint), sum.value, side < 0 ? "below" : "above",
                                   shortest(side < 0 ? constraint.lower : constraint.upper)));
  }
  return broken;
}

}  // namespace repose
