#include "measurement_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace repose::cli {

void print_measurement(const dem_adapter::Measurement& m) {
  for (const auto& [name, value] : m.kpis) fmt::print("{:<24} {:>10.5g}\n", name, value);
  if (!m.details.empty()) fmt::print("\n");
  for (const auto& [name, value] : m.details) fmt::print("  {:<28} {:>10.5g}\n", name, value);
  if (m.outcome == dem_adapter::Outcome::kpi_undefined)
    fmt::print("note: {}: {}\n", to_string(m.outcome), m.failure);
  for (const auto& warning : m.warnings) fmt::print("note: {}\n", warning);
}

nlohmann::json measurement_json(const dem_adapter::Measurement& m) {
  return {{"outcome", to_string(m.outcome)},
          {"kpis", m.kpis},
          {"details", m.details},
          {"failure", m.failure},
          {"warnings", m.warnings}};
}

}  // namespace repose::cli
