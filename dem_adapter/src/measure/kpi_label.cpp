#include <algorithm>
#include <utility>

#include "repose/dem_adapter/measurement.hpp"

namespace repose::dem_adapter {

KpiLabel label_of(const std::string& kpi) {
  static const std::vector<std::pair<std::string, std::string>> kUnits{
      {"_deg", "deg"}, {"_kg_s", "kg/s"}, {"_kg_m3", "kg/m3"}, {"_kg", "kg"},
      {"_n_m", "N m"}, {"_n", "N"},       {"_s", "s"}};
  KpiLabel label{.words = kpi, .unit = "1"};
  for (const auto& [suffix, unit] : kUnits)
    if (kpi.size() > suffix.size() && kpi.ends_with(suffix)) {
      label = {.words = kpi.substr(0, kpi.size() - suffix.size()), .unit = unit};
      break;
    }
  std::replace(label.words.begin(), label.words.end(), '_', ' ');
  return label;
}

}  // namespace repose::dem_adapter
