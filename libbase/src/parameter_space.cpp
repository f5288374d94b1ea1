#include "repose/base/parameter_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/base/toml.hpp"

namespace repose {
namespace {

void check_range(const Parameter& p) {
  if (p.name.empty()) throw InputError("a parameter has an empty name; give it one");
  if (!std::isfinite(p.lower) || !std::isfinite(p.upper) || p.lower >= p.upper)
    throw InputError(
        fmt::format("parameter {}: lower = {}, upper = {}: lower must be finite and below upper",
                    p.name, shortest(p.lower), shortest(p.upper)));
  if (p.scale == Scale::log && p.lower <= 0.0)
    throw InputError(
        fmt::format("parameter {}: lower = {} on a logarithmic scale: it must be above 0", p.name,
                    shortest(p.lower)));
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

}  // namespace

Parameter read_parameter(const TomlTable& parameters, const std::string& name) {
  const auto table = parameters.table(name);
  Parameter p{.name = name, .lower = table.number("lower"), .upper = table.number("upper")};
  if (table.choice_or("scale", "linear", {"linear", "log"}) == "log") p.scale = Scale::log;
  p.unit = table.text_or("unit", "1");
  if (p.lower >= p.upper)
    table.fail("lower", fmt::format("{} is not below upper = {}; swap or widen them",
                                    shortest(p.lower), shortest(p.upper)));
  if (p.scale == Scale::log && p.lower <= 0.0)
    table.fail("lower", fmt::format("{} has no logarithm; it must be above 0", shortest(p.lower)));
  return p;
}

ParameterSpace::ParameterSpace(std::vector<Parameter> free, ParameterValues fixed,
                               std::vector<Tie> ties)
    : free_(std::move(free)), fixed_(std::move(fixed)) {
  std::set<std::string> all;
  std::set<std::string> known;
  const auto add = [&](const std::string& name) {
    if (!all.insert(name).second)
      throw InputError(fmt::format("parameter {} is given twice; keep one of the two", name));
  };
  for (const auto& p : free_) {
    check_range(p);
    add(p.name);
    known.insert(p.name);
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
    add(tie.name);
  }
  ties_ = in_computable_order(std::move(ties), std::move(known));
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
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    const auto& p = free_[static_cast<std::size_t>(i)];
    const double u = std::clamp(unit[i], 0.0, 1.0);
    const double value = p.scale == Scale::log
                             ? std::exp(std::log(p.lower) + u * std::log(p.upper / p.lower))
                             : p.lower + u * (p.upper - p.lower);
    natural[i] = std::clamp(value, p.lower, p.upper);
  }
  return natural;
}

Vector ParameterSpace::to_unit(const Vector& natural) const {
  REPOSE_ASSERT(static_cast<std::size_t>(natural.size()) == dimension(),
                fmt::format("{}", natural.size()));
  Vector unit(natural.size());
  for (Eigen::Index i = 0; i < natural.size(); ++i) {
    const auto& p = free_[static_cast<std::size_t>(i)];
    unit[i] = p.scale == Scale::log ? std::log(natural[i] / p.lower) / std::log(p.upper / p.lower)
                                    : (natural[i] - p.lower) / (p.upper - p.lower);
  }
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

}  // namespace repose
