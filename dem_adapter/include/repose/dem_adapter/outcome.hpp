// What became of a run, by name, and what it cost.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace repose::dem_adapter {

/// How a run ended; all but `finished` are failures, of which only `kpi_undefined` leaves KPIs.
enum class Outcome {
  finished,
  kpi_undefined,      ///< some KPIs have no value, the others stand
  nothing_flowed,     ///< of the scenario: no material left
  jammed_outlet,      ///< of the scenario: it stopped to flow early
  particles_lost,     ///< left the domain
  non_finite,         ///< a position or a KPI is not a number
  unphysical,         ///< overlaps or speeds that nothing explains
  time_limit,         ///< ended by us
  crash,              ///< ended by a signal of its own making
  killed,             ///< ended by somebody else, again and again (out of memory?)
  engine_failed,      ///< said so itself, for a reason without a name here
  output_unreadable,  ///< finished, but what it left cannot be measured
};

/// As in files and tables: "jammed-outlet".
const char* to_string(Outcome outcome);
/// In the order of the enumeration.
const std::vector<Outcome>& all_outcomes();
/// The outcome of this name. Throws InputError naming those that exist.
Outcome outcome_named(std::string_view name);
/// Whether there are no KPIs.
bool is_failure(Outcome outcome);

/// What a run used, over all parts of one that was stopped and went on; a part that was killed
/// together with the campaign is not known.
struct Resources {
  double wall_time_s = 0.0;
  double cpu_time_s = 0.0;             ///< of all its processes
  std::int64_t peak_memory_bytes = 0;  ///< resident, of its largest process
  int ranks = 1;                       ///< processes that simulated together
  int parts = 1;                       ///< how often it was started
  Resources& operator+=(const Resources& later);
};

}  // namespace repose::dem_adapter
