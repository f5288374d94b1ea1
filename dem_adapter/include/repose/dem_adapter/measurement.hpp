// What is measured from one run: KPIs by name, or the reason why there are none.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace repose::dem_adapter {

struct Measurement {
  /// By name, in the unit of the name's suffix; all finite. Empty if the run failed.
  std::map<std::string, double> kpis;
  /// How the KPIs came about: left and right angle, 98 % time, largest overlap, ...
  std::map<std::string, double> details;
  /// Why the run cannot be used, in one sentence; empty if it can.
  std::string failure;
  /// What a careful reader should know about a run that can be used.
  std::vector<std::string> warnings;
};

/// A KPI's name in words and the unit that its suffix names: mass_flow_kg_s is "mass flow", "kg/s".
struct KpiLabel {
  std::string words;
  std::string unit;  ///< "1" if the name has no unit
};
KpiLabel label_of(const std::string& kpi);

}  // namespace repose::dem_adapter
