#include "repose/dem_adapter/dataset.hpp"

#include <fmt/format.h>

#include <limits>

#include "outcome_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::dem_adapter {

const char* to_string(Phase phase) {
  switch (phase) {
    case Phase::screening:
      return "screening";
    case Phase::sampling:
      return "sampling";
    case Phase::adaptive:
      return "adaptive";
    case Phase::verification:
      return "verification";
    case Phase::baseline:
      return "baseline";
  }
  return "?";
}

std::size_t Dataset::failed() const {
  std::size_t count = 0;
  for (const auto& o : observations) count += o.outcome.failed() ? 1 : 0;
  return count;
}

std::uint64_t run_seed(const Study& study, Phase phase, int batch, std::size_t index,
                       int repetition) {
  // Verification and the baseline share a seed for each repetition; every other run has its own.
  if (phase == Phase::verification || phase == Phase::baseline)
    return derive_seed(derive_seed(study.seed, 1), static_cast<std::uint64_t>(repetition));
  if (study.seeds == Seeds::common)
    return derive_seed(derive_seed(study.seed, 2), static_cast<std::uint64_t>(repetition));
  const auto of_phase = derive_seed(study.seed, 2 + static_cast<std::uint64_t>(phase));
  const auto of_point = derive_seed(of_phase, (static_cast<std::uint64_t>(batch) << 32) | index);
  return derive_seed(of_point, static_cast<std::uint64_t>(repetition));
}

void simulate(Dataset& data, const Study& study, const Campaign& campaign, Phase phase, int batch,
              const Matrix& unit_points, int repetitions, const ProgressCallback& progress) {
  std::vector<ParameterValues> values;  // of each run
  std::vector<Observation> added;
  for (Eigen::Index i = 0; i < unit_points.rows(); ++i) {
    const Vector unit = unit_points.row(i).transpose();
    for (int r = 0; r < repetitions; ++r) {
      const auto seed = run_seed(study, phase, batch, static_cast<std::size_t>(i), r);
      values.push_back(study.space.complete(study.space.from_unit(unit)));
      added.push_back({.point = data.points.size(), .repetition = r, .seed = seed, .outcome = {}});
    }
    data.points.push_back({.phase = phase, .batch = batch, .unit = unit});
  }
  const auto make_input = [&](std::size_t run, int attempt) {
    return study.scenario.make_input(values[run], attempt_seed(added[run].seed, attempt));
  };
  auto outcomes = campaign.outcomes({.count = added.size(), .make_input = make_input}, progress);
  for (std::size_t i = 0; i < added.size(); ++i) {
    added[i].outcome = std::move(outcomes[i]);
    added[i].seed = added[i].outcome.seed;
    if (added[i].outcome.failed()) added[i].outcome.measurement.kpis = study.failures.penalty;
    data.observations.push_back(std::move(added[i]));
  }
}

table::Table Dataset::table(const Study& study) const {
  std::vector<std::string> phase;
  std::vector<std::int64_t> point, batch, repetition;
  OutcomeColumns outcomes(study.scenario.kpi_names());
  const auto& parameters = study.space.parameters();
  std::vector<std::vector<double>> factors(parameters.size());
  for (const auto& o : observations) {
    const auto& p = points[o.point];
    phase.emplace_back(to_string(p.phase));
    point.push_back(static_cast<std::int64_t>(o.point));
    batch.push_back(p.batch);
    repetition.push_back(o.repetition);
    const Vector natural = study.space.from_unit(p.unit);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      factors[i].push_back(natural[static_cast<Eigen::Index>(i)]);
    outcomes.add(o.outcome);
  }
  using table::Column;
  using table::Role;
  table::Table result;
  result.add(Column{.name = "phase", .role = Role::group, .range = {}, .values = phase});
  result.add(Column{.name = "point", .role = Role::id, .range = {}, .values = point});
  result.add(Column{.name = "batch", .role = Role::none, .range = {}, .values = batch});
  result.add(
      Column{.name = "repetition", .role = Role::replicate, .range = {}, .values = repetition});
  for (std::size_t i = 0; i < parameters.size(); ++i)
    result.add(table::factor_column(parameters[i], factors[i]));
  outcomes.add_to(result);
  return result;
}

}  // namespace repose::dem_adapter
