#include "parameter_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "repose/base/text.hpp"

namespace repose::dem_adapter {

std::string unknown_name(const std::string& name, const std::vector<std::string>& known,
                         const std::set<std::string>& sources) {
  if (sources.count(name) > 0 || std::find(known.begin(), known.end(), name) != known.end())
    return "";
  const auto similar = closest_name(name, known);
  return fmt::format(
      "the scenario has no parameter {} and no tie uses it; {}", name,
      similar.empty() ? "it has " + listed(known) : fmt::format("did you mean {}?", similar));
}

std::string unusable_name(const std::string& name, const std::vector<std::string>& kpis) {
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '_');
  });
  if (!plain) return "a name may hold letters, digits and _ only";
  static const std::set<std::string> kColumns{
      "phase", "point",   "batch", "repetition",  "seed",       "outcome",
      "run",   "failure", "pair",  "wall_time_s", "cpu_time_s", "peak_memory_bytes"};
  if (kColumns.count(name) > 0 || std::find(kpis.begin(), kpis.end(), name) != kpis.end())
    return "this name is taken by a column of the tables of runs; choose another";
  return "";
}

TiesAndFixed read_ties_and_fixed(const TomlTable& root, const std::vector<std::string>& known) {
  TiesAndFixed result;
  const auto check = [&](const TomlTable& table, const std::string& name) {
    const auto wrong = unknown_name(name, known, result.sources);
    if (!wrong.empty()) table.fail(name, wrong);
  };
  if (const auto table = root.table_if_present("ties"))
    for (const auto& name : table->keys()) {
      if (const auto wrong = unknown_name(name, known, {}); !wrong.empty())
        table->fail(name, wrong);
      result.ties.push_back({.name = name, .sources = table->texts(name)});
      result.sources.insert(result.ties.back().sources.begin(), result.ties.back().sources.end());
    }
  if (const auto table = root.table_if_present("fixed"))
    for (const auto& name : table->keys()) {
      check(*table, name);
      result.fixed[name] = table->number(name);
    }
  return result;
}

}  // namespace repose::dem_adapter
