#include "outcome_columns.hpp"

#include <limits>
#include <utility>

#include "repose/dem_adapter/measurement.hpp"

namespace repose::dem_adapter {

OutcomeColumns::OutcomeColumns(std::vector<std::string> kpis)
    : kpi_names_(std::move(kpis)), kpis_(kpi_names_.size()) {}

void OutcomeColumns::add(const RunOutcome& outcome) {
  seed_.push_back(static_cast<std::int64_t>(outcome.seed));
  for (std::size_t i = 0; i < kpi_names_.size(); ++i)
    kpis_[i].push_back(
        outcome.measurement.kpi(kpi_names_[i]).value_or(std::numeric_limits<double>::quiet_NaN()));
  outcome_.emplace_back(to_string(outcome.measurement.outcome));
  failure_.push_back(outcome.measurement.failure);
  run_.push_back(outcome.key);
  wall_time_.push_back(outcome.resources.wall_time_s);
  cpu_time_.push_back(outcome.resources.cpu_time_s);
  memory_.push_back(outcome.resources.peak_memory_bytes);
}

void OutcomeColumns::add_to(table::Table& table) {
  const auto add = [&](std::string name, std::string unit, table::Role role, table::Values values) {
    table.add({.name = std::move(name),
               .unit = std::move(unit),
               .role = role,
               .range = {},
               .values = std::move(values)});
  };
  using table::Role;
  add("seed", "1", Role::none, std::exchange(seed_, {}));
  for (std::size_t i = 0; i < kpi_names_.size(); ++i)
    add(kpi_names_[i], label_of(kpi_names_[i]).unit, Role::response, std::exchange(kpis_[i], {}));
  add("outcome", "1", Role::none, std::exchange(outcome_, {}));
  add("failure", "1", Role::none, std::exchange(failure_, {}));
  add("run", "1", Role::none, std::exchange(run_, {}));
  add("wall_time_s", "s", Role::none, std::exchange(wall_time_, {}));
  add("cpu_time_s", "s", Role::none, std::exchange(cpu_time_, {}));
  add("peak_memory_bytes", "B", Role::none, std::exchange(memory_, {}));
}

}  // namespace repose::dem_adapter
