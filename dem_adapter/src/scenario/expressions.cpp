#include "scenario/expressions.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

[[noreturn]] void refuse_unknown(const std::string& name,
                                 const std::map<std::string, double>& values) {
  std::vector<std::string> known;
  for (const auto& [other, value] : values) known.push_back(other);
  const std::string similar = closest_name(name, known);
  throw InputError(fmt::format("there is no {}; {}", name,
                               !similar.empty() ? "did you mean " + similar + "?"
                               : known.empty()  ? "no parameter is defined"
                                                : "known are " + listed(known)));
}

[[noreturn]] void refuse_name(const std::string& name) {
  throw InputError(fmt::format(
      "\"{}\" cannot be used in expressions: a name has letters, digits and _, does not begin with "
      "a digit and is not that of a function or constant",
      name));
}

}  // namespace

void Expressions::define(const std::string& name, double value) {
  if (values_.count(name) > 0)
    throw InputError(fmt::format("there are two of the name {}; rename one", name));
  mu::Parser parser;
  const bool is_taken = parser.GetFunDef().count(name) > 0 || parser.GetConst().count(name) > 0;
  try {
    if (!is_taken) parser.DefineVar(name, &value);
  } catch (const mu::ParserError&) {
    refuse_name(name);
  }
  if (is_taken) refuse_name(name);
  values_[name] = value;
}

double Expressions::value(const std::string& expression) {
  auto values = values_;
  double result = 0.0;
  try {
    mu::Parser parser;
    for (auto& [name, value] : values) parser.DefineVar(name, &value);
    parser.SetExpr(expression);
    for (const auto& [name, place] : parser.GetUsedVar()) {
      if (values_.count(name) == 0) refuse_unknown(name, values_);
      used_.insert(name);
    }
    int results = 0;
    const double* const all = parser.Eval(results);
    if (results != 1) throw InputError(fmt::format("has {} results; a number has one", results));
    result = all[0];
  } catch (const mu::ParserError& error) {
    throw InputError(fmt::format("is no expression: {}", error.GetMsg()));
  }
  if (values != values_) throw InputError("must not assign; compare by ==");
  return result;
}

}  // namespace repose::dem_adapter
