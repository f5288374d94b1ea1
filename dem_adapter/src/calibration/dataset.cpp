#include "repose/dem_adapter/dataset.hpp"

#include <fmt/format.h>

#include <limits>

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
  for (const auto& o : observations) count += o.outcome.usable() ? 0 : 1;
  return count;
}

std::uint64_t run_seed(std::uint64_t study_seed, Phase phase, int batch, std::size_t index,
                       int repetition) {
  // Verification and the baseline share a seed for each repetition; every other run has its own.
  if (phase == Phase::verification || phase == Phase::baseline)
    return derive_seed(derive_seed(study_seed, 1), static_cast<std::uint64_t>(repetition));
  const auto of_phase = derive_seed(study_seed, 2 + static_cast<std::uint64_t>(phase));
  const auto of_point = derive_seed(of_phase, (static_cast<std::uint64_t>(batch) << 32) | index);
  return derive_seed(of_point, static_cast<std::uint64_t>(repetition));
}

void simulate(Dataset& data, const Study& study, const Campaign& campaign, Phase phase, int batch,
              const Matrix& unit_points, int repetitions, const ProgressCallback& progress) {
  std::vector<scene::Case> cases;
  std::vector<Observation> added;
  for (Eigen::Index i = 0; i < unit_points.rows(); ++i) {
    const Vector unit = unit_points.row(i).transpose();
    const auto values = study.space.complete(study.space.from_unit(unit));
    for (int r = 0; r < repetitions; ++r) {
      const auto seed = run_seed(study.seed, phase, batch, static_cast<std::size_t>(i), r);
      cases.push_back(study.scenario.make_case(values, seed));
      added.push_back({.point = data.points.size(), .repetition = r, .seed = seed, .outcome = {}});
    }
    data.points.push_back({.phase = phase, .batch = batch, .unit = unit});
  }
  auto outcomes = campaign.run(cases, progress);
  for (std::size_t i = 0; i < added.size(); ++i) {
    added[i].outcome = std::move(outcomes[i]);
    data.observations.push_back(std::move(added[i]));
  }
}

table::Table Dataset::table(const Study& study) const {
  std::vector<std::string> phase, failure, key;
  std::vector<std::int64_t> point, batch, repetition, seed;
  std::vector<double> wall_time;
  const auto& parameters = study.space.parameters();
  std::vector<std::vector<double>> factors(parameters.size());
  const auto kpi_names = study.scenario.kpi_names();
  std::vector<std::vector<double>> kpis(kpi_names.size());
  for (const auto& o : observations) {
    const auto& p = points[o.point];
    phase.emplace_back(to_string(p.phase));
    point.push_back(static_cast<std::int64_t>(o.point));
    batch.push_back(p.batch);
    repetition.push_back(o.repetition);
    seed.push_back(static_cast<std::int64_t>(o.seed));
    const Vector natural = study.space.from_unit(p.unit);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      factors[i].push_back(natural[static_cast<Eigen::Index>(i)]);
    for (std::size_t i = 0; i < kpi_names.size(); ++i) {
      const auto it = o.outcome.measurement.kpis.find(kpi_names[i]);
      kpis[i].push_back(it == o.outcome.measurement.kpis.end()
                            ? std::numeric_limits<double>::quiet_NaN()
                            : it->second);
    }
    failure.push_back(o.outcome.measurement.failure);
    key.push_back(o.outcome.key);
    wall_time.push_back(o.outcome.wall_time_s);
  }
  using table::Column;
  using table::Role;
  table::Table result;
  result.add(Column{.name = "phase", .role = Role::group, .range = {}, .values = phase});
  result.add(Column{.name = "point", .role = Role::id, .range = {}, .values = point});
  result.add(Column{.name = "batch", .role = Role::none, .range = {}, .values = batch});
  result.add(
      Column{.name = "repetition", .role = Role::replicate, .range = {}, .values = repetition});
  result.add(Column{.name = "seed", .role = Role::none, .range = {}, .values = seed});
  for (std::size_t i = 0; i < parameters.size(); ++i)
    result.add(table::factor_column(parameters[i], factors[i]));
  for (std::size_t i = 0; i < kpi_names.size(); ++i)
    result.add(Column{.name = kpi_names[i],
                      .unit = label_of(kpi_names[i]).unit,
                      .role = Role::response,
                      .range = {},
                      .values = kpis[i]});
  result.add(Column{.name = "failure", .role = Role::none, .range = {}, .values = failure});
  result.add(Column{.name = "run", .role = Role::none, .range = {}, .values = key});
  result.add(Column{
      .name = "wall_time_s", .unit = "s", .role = Role::none, .range = {}, .values = wall_time});
  return result;
}

}  // namespace repose::dem_adapter
