// A measurement as text and JSON, alike for every subcommand that measures.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "repose/dem_adapter/measurement.hpp"

namespace repose::cli {

/// KPIs, details and notes, a line each.
void print_measurement(const dem_adapter::Measurement& measurement);
/// Members kpis, details, failure, warnings.
nlohmann::json measurement_json(const dem_adapter::Measurement& measurement);

}  // namespace repose::cli
