#include "repose/dem_adapter/measurement.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/text.hpp"

namespace repose::dem_adapter {

void Measurement::fail(Outcome reason, std::string sentence) {
  outcome = reason;
  failure = std::move(sentence);
  kpis.clear();
}

void Measurement::drop_undefined_kpis() {
  std::vector<std::string> undefined;
  for (const auto& [name, value] : kpis)
    if (!std::isfinite(value)) undefined.push_back(name);
  std::erase_if(kpis, [](const auto& kpi) { return !std::isfinite(kpi.second); });
  std::erase_if(details, [](const auto& detail) { return !std::isfinite(detail.second); });
  if (undefined.empty() || outcome != Outcome::finished) return;
  outcome = kpis.empty() ? Outcome::non_finite : Outcome::kpi_undefined;
  failure =
      fmt::format("{} {} undefined: the output of the run does not determine {}", listed(undefined),
                  undefined.size() == 1 ? "is" : "are", undefined.size() == 1 ? "it" : "them");
}

}  // namespace repose::dem_adapter
