#include "repose/dem_adapter/rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/shipped_scenarios.hpp"
#include "scenario/expressions.hpp"

namespace repose::dem_adapter {
namespace {

const std::string kParameters = "parameters";
const std::string kDerived = "derived";

/// A rig with values in place: its table, in which expressions are evaluated with `names`.
struct Evaluated {
  std::shared_ptr<Expressions> names;
  TomlTable table;
};

/// Parameters and what is derived from them, in the order of the file.
Evaluated evaluated(const TomlTable& rig, const ParameterValues& values) {
  const auto names = std::make_shared<Expressions>();
  auto table = rig.with_expressions(
      [names](const std::string& expression) { return names->value(expression); });
  static_cast<void>(table.text("scenario"));
  const auto define = [&](const TomlTable& where, const std::string& name, double value) {
    try {
      names->define(name, value);
    } catch (const InputError& error) {
      where.fail(name, error.what());
    }
  };
  if (const auto parameters = rig.table_if_present(kParameters))
    for (const auto& name : parameters->keys()) define(*parameters, name, values.at(name));
  if (const auto derived = table.table_if_present(kDerived))
    for (const auto& name : derived->keys()) define(*derived, name, derived->number(name));
  return {names, table};
}

scene::Case case_of(const Evaluated& rig) {
  return scene::case_from(rig.table, std::filesystem::absolute(rig.table.file()).parent_path());
}

/// Formulas may use what is derived, too.
ParameterValues values_of(const TomlTable& rig, const Evaluated& from,
                          const ParameterValues& values) {
  ParameterValues all = values;
  if (const auto derived = rig.table_if_present(kDerived))
    for (const auto& name : derived->keys()) all[name] = from.names->value(name);
  return all;
}

/// A value of whatever type as text; an expression in a list is told to whoever evaluates it.
std::string value_text(const TomlTable& table, const std::string& key) {
  const auto read = [&](const auto& as_text) -> std::optional<std::string> {
    try {
      return as_text();
    } catch (const InputError&) {
      return std::nullopt;  // another type
    }
  };
  if (const auto text = read([&] { return table.text(key); })) return *text;
  if (const auto number = read([&] { return shortest(table.number(key)); })) return *number;
  if (const auto texts = read([&] { return fmt::format("{}", fmt::join(table.texts(key), ",")); }))
    return *texts;
  std::string all;
  for (const double number : table.numbers(key)) all += shortest(number) + ",";
  return all;
}

void refuse_unused(const TomlTable& rig, const std::string& table, const Expressions& names) {
  const auto given = rig.table_if_present(table);
  if (!given) return;
  for (const auto& name : given->keys())
    if (names.used().count(name) == 0)
      given->fail(name,
                  "no expression uses it; write \"= " + name + "\" where it belongs, or remove it");
}

}  // namespace

// The copy notes by itself which keys are known: check() reads them all, with expressions.
Rig::Rig(const TomlTable& table, std::string name)
    : table_(table.with_expressions({})), name_(std::move(name)) {
  for (const auto& key : table.keys()) static_cast<void>(table.has(key));
  if (const auto run = table_.table_if_present("run"); run && run->has("seed"))
    run->fail("seed", "a rig has no seed of its own: whoever runs it gives one; remove it");
  if (const auto parameters = table_.table_if_present(kParameters))
    for (const auto& parameter : parameters->keys())
      defaults_[parameter] = parameters->number(parameter);
}

Rig Rig::read(const TomlTable& table) {
  Rig rig(table, "rig");
  rig.check();
  for (const auto& kpi : rig.table_.tables("kpi")) rig.kpi_names_.push_back(kpi.text("name"));
  return rig;
}

Rig Rig::read_shipped(const std::string& name, const TomlTable& table) {
  const auto& shipped = shipped_scenario(name);
  Rig rig = read(TomlTable::parse(shipped.text, "shipped scenario " + name));
  rig.name_ = name;
  if (const auto given = table.table_if_present(kParameters)) {
    rig.override_defaults(*given);
    try {
      rig.check();
    } catch (const InputError& error) {
      given->fail("", error.what());
    }
  }
  return rig;
}

void Rig::override_defaults(const TomlTable& parameters) {
  for (const auto& name : parameters.keys()) {
    const auto it = defaults_.find(name);
    if (it == defaults_.end())
      parameters.fail(name, fmt::format("the scenario {} has no such parameter; it has {}", name_,
                                        listed(parameter_names())));
    it->second = parameters.number(name);
  }
}

void Rig::check() const {
  const Evaluated rig = evaluated(table_, defaults_);
  const auto tables = rig.table.tables("kpi");
  const auto kpis = read_kpis(tables);
  const scene::Case scene = case_of(rig);
  for (std::size_t i = 0; i < kpis.size(); ++i) {
    try {
      check_kpi(kpis[i], scene);
      if (const auto* formula = std::get_if<FormulaKpi>(&kpis[i].kind))
        rig.names->value(formula->formula);
      rig.names->define(kpis[i].name, 1.0);
    } catch (const InputError& error) {
      tables[i].fail("", fmt::format("{}: {}", kpis[i].name, error.what()));
    }
  }
  refuse_unused(table_, kParameters, *rig.names);
  refuse_unused(table_, kDerived, *rig.names);
}

std::vector<std::string> Rig::parameter_names() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : defaults_) names.push_back(name);
  return names;
}

std::vector<std::string> Rig::kpi_names() const {
  return kpi_names_;
}

std::string Rig::kpi_definition() const {
  std::string text;
  const auto table = table_.with_expressions([&text](const std::string& expression) {
    text += "(" + expression + ")";
    return 0.0;
  });
  auto parts = table.tables("kpi");
  if (const auto derived = table.table_if_present(kDerived)) parts.push_back(*derived);
  for (const auto& part : parts)
    for (const auto& key : part.keys()) text += key + "=" + value_text(part, key) + "\n";
  return text;
}

scene::Case Rig::make_case(const ParameterValues& values, std::uint64_t seed) const {
  ParameterValues all = defaults_;
  for (auto& [name, value] : all)
    if (const auto it = values.find(name); it != values.end()) value = it->second;
  const Evaluated rig = evaluated(table_, all);
  static_cast<void>(rig.table.has("kpi"));
  scene::Case scene = case_of(rig);
  scene.seed = seed;
  scene.parameters = all;
  return scene;
}

Measurement Rig::measure(const scene::Run& run) const {
  const auto& values = run.scene().parameters;
  for (const auto& [name, value] : defaults_)
    if (values.count(name) == 0)
      throw InputError(fmt::format(
          "the run has no parameter {}: it was not made by this scenario, {}", name, name_));
  const Evaluated rig = evaluated(table_, values);
  const auto kpis = read_kpis(rig.table.tables("kpi"));
  return measure_kpis(kpis, run, values_of(table_, rig, values));
}

}  // namespace repose::dem_adapter
