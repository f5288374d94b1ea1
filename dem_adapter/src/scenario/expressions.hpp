// Arithmetic with named values, as rigs write it: "0.5 * width_m". Evaluated by muParser.
#pragma once

#include <map>
#include <set>
#include <string>

namespace repose::dem_adapter {

/// Operators + - * / ^, comparisons, && ||, a ? b : c; functions sqrt, abs, exp, ln, log10, sin,
/// cos, tan (radians), asin, acos, atan, atan2, min, max, rint, sign, ...; the constants _pi, _e.
class Expressions {
 public:
  /// Throws InputError if the name is no identifier, taken, or that of a function.
  void define(const std::string& name, double value);
  /// Throws InputError for an unknown name, with the likely one, a syntax error or an assignment.
  /// What is not finite is returned as it is.
  double value(const std::string& expression);
  bool has(const std::string& name) const { return values_.count(name) > 0; }
  /// Names that expressions asked for so far.
  const std::set<std::string>& used() const { return used_; }

 private:
  std::map<std::string, double> values_;
  std::set<std::string> used_;
};

}  // namespace repose::dem_adapter
