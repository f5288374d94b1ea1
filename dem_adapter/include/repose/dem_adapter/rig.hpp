// A user's own rig: the tables of a case file with parameters in them, and definitions of KPIs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/base/toml.hpp"
#include "repose/dem_adapter/kpi_definition.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

/// The keys of a case file, [parameters] with a default each, [derived] with expressions of
/// parameters and of what stands above, and [[kpi]]. Wherever a number stands, but in [parameters],
/// an expression may stand (docs/how-to/scenarios.md). Files are relative to the rig's.
class Rig {
 public:
  /// Reads and checks with the defaults. Throws InputError with file and line for whatever
  /// scene::parse_case() would, an expression that cannot be evaluated, a parameter that no
  /// expression uses, a KPI of what the case does not have.
  static Rig read(const TomlTable& table);
  /// A shipped rig (shipped_scenarios.hpp), whose defaults `table` overrides by its [parameters].
  static Rig read_shipped(const std::string& name, const TomlTable& table);

  const std::string& name() const { return name_; }
  std::vector<std::string> parameter_names() const;
  std::vector<std::string> kpi_names() const;
  /// Changes with [[kpi]] and [derived]: a text of both.
  std::string kpi_definition() const;
  /// Values are recorded in Case::parameters, from which measure() takes them.
  scene::Case make_case(const ParameterValues& values, std::uint64_t seed) const;
  /// Throws InputError if the run was not made by this rig.
  Measurement measure(const scene::Run& run) const;

 private:
  Rig(const TomlTable& table, std::string name);
  void override_defaults(const TomlTable& parameters);
  void check() const;

  TomlTable table_;
  std::string name_;
  ParameterValues defaults_;
  std::vector<std::string> kpi_names_;
};

}  // namespace repose::dem_adapter
