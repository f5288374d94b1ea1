// The columns of a table of runs that come from their outcomes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "repose/dem_adapter/run_store.hpp"
#include "repose/table/table.hpp"

namespace repose::dem_adapter {

/// seed, KPIs (NaN where there is none), outcome, failure, run, wall_time_s, cpu_time_s,
/// peak_memory_bytes.
class OutcomeColumns {
 public:
  explicit OutcomeColumns(std::vector<std::string> kpis);
  void add(const RunOutcome& outcome);
  /// Appends the columns to a table of as many rows, and is empty again.
  void add_to(table::Table& table);

 private:
  std::vector<std::string> kpi_names_;
  std::vector<std::vector<double>> kpis_;
  std::vector<std::string> outcome_, failure_, run_;
  std::vector<std::int64_t> seed_, memory_;
  std::vector<double> wall_time_, cpu_time_;
};

}  // namespace repose::dem_adapter
