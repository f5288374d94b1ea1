// Parameter spaces read from TOML.
#include <fmt/format.h>

#include "repose/base/error.hpp"
#include "repose/base/parameter_space.hpp"
#include "repose/base/text.hpp"
#include "repose/base/toml.hpp"

namespace repose {
namespace {

/// Reports what a constructor refuses with file and line of `key`.
template <class Make>
auto with_line(const TomlTable& table, const std::string& key, Make&& make) {
  try {
    return make();
  } catch (const InputError& error) {
    table.fail(key, error.what());
  }
}

Scale read_scale(const TomlTable& table) {
  return table.choice_or("scale", "linear", {"linear", "log"}) == "log" ? Scale::log
                                                                        : Scale::linear;
}

Parameter read_range(const TomlTable& table, const std::string& name) {
  Parameter p{.name = name,
              .lower = table.number("lower"),
              .upper = table.number("upper"),
              .scale = read_scale(table),
              .unit = table.text_or("unit", "1")};
  if (table.flag_or("integer", false)) p.kind = ParameterKind::integer;
  if (p.lower >= p.upper)
    table.fail("lower", fmt::format("{} is not below upper = {}; swap or widen them",
                                    shortest(p.lower), shortest(p.upper)));
  if (p.scale == Scale::log && p.lower <= 0.0)
    table.fail("lower", fmt::format("{} has no logarithm; it must be above 0", shortest(p.lower)));
  return p;
}

Parameter read_levels(const TomlTable& table, const std::string& name) {
  Parameter p{.name = name, .unit = table.text_or("unit", "1"), .kind = ParameterKind::levels};
  p.levels = table.numbers("levels");
  return p;
}

Parameter read_categories(const TomlTable& table, const std::string& name) {
  Parameter p{.name = name, .kind = ParameterKind::categorical};
  p.categories = table.texts("categories");
  return p;
}

LinearConstraint read_constraint(const TomlTable& constraints, const std::string& name) {
  const auto table = constraints.table(name);
  const auto coefficients = table.table("coefficients");
  LinearConstraint constraint{.name = name, .coefficients = {}};
  for (const auto& key : coefficients.keys())
    constraint.coefficients[key] = coefficients.number(key);
  constraint.lower = table.number_or("lower", constraint.lower);
  constraint.upper = table.number_or("upper", constraint.upper);
  return constraint;
}

}  // namespace

Parameter read_parameter(const TomlTable& parameters, const std::string& name) {
  const auto table = parameters.table(name);
  const Parameter p = table.has("levels")       ? read_levels(table, name)
                      : table.has("categories") ? read_categories(table, name)
                                                : read_range(table, name);
  // A space of this one parameter checks it where its line is known.
  return with_line(parameters, name, [&] { return ParameterSpace({p}).parameters().front(); });
}

ParameterSpace read_parameter_space(const TomlTable& root) {
  const auto table = root.table("parameters");
  std::vector<Parameter> parameters;
  for (const auto& name : table.keys()) parameters.push_back(read_parameter(table, name));
  if (parameters.empty()) table.fail("", "there are no parameters; give at least one");
  ParameterValues fixed;
  if (const auto t = root.table_if_present("fixed"))
    for (const auto& name : t->keys()) fixed[name] = t->number(name);
  std::vector<Tie> ties;
  if (const auto t = root.table_if_present("ties"))
    for (const auto& name : t->keys()) ties.push_back({name, t->texts(name)});
  auto space =
      with_line(root, "parameters", [&] { return ParameterSpace(parameters, fixed, ties); });
  const auto t = root.table_if_present("constraints");
  if (!t) return space;
  std::vector<LinearConstraint> constraints;
  for (const auto& name : t->keys()) {
    constraints.push_back(read_constraint(*t, name));
    space =
        with_line(*t, name, [&] { return ParameterSpace(parameters, fixed, ties, constraints); });
  }
  return space;
}

}  // namespace repose
