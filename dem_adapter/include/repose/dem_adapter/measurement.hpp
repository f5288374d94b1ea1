// What is measured from one run: KPIs by name, or the reason why there are none.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/outcome.hpp"

namespace repose::dem_adapter {

struct Measurement {
  Outcome outcome = Outcome::finished;
  /// By name, in the unit of the name's suffix; all finite. Empty if the run failed; one that is
  /// undefined is missing.
  std::map<std::string, double> kpis;
  /// How the KPIs came about: left and right angle, 98 % time, largest overlap, ...
  std::map<std::string, double> details;
  /// Why the run, or a KPI of it, cannot be used, in one sentence; empty if `outcome` is finished.
  std::string failure;
  /// What a careful reader should know about a run that can be used.
  std::vector<std::string> warnings;

  /// A KPI's value if it has one.
  std::optional<double> kpi(const std::string& name) const {
    const auto it = kpis.find(name);
    return it == kpis.end() ? std::nullopt : std::optional(it->second);
  }
  /// Makes it a failure without KPIs; `sentence` says why.
  void fail(Outcome reason, std::string sentence);
  /// Takes out KPIs that are not finite and says so: kpi_undefined, or non_finite if none is left.
  void drop_undefined_kpis();
};

/// A KPI's name in words and the unit that its suffix names: mass_flow_kg_s is "mass flow", "kg/s".
struct KpiLabel {
  std::string words;
  std::string unit;  ///< "1" if the name has no unit
};
KpiLabel label_of(const std::string& kpi);

}  // namespace repose::dem_adapter
