#include "repose/dem_adapter/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "parameter_tables.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/doe/designs.hpp"

namespace repose::dem_adapter {
namespace {

constexpr Allowed kAtLeastOne{.lower = 1.0, .upper = 1e6};
constexpr Allowed kShare{.lower = 0.0, .upper = 1.0, .open_lower = true};
constexpr int kFewestFactors = 3, kMostFactors = 50;  // of a screening design here

int count(const TomlTable& table, std::string_view key, int fallback, const Allowed& allowed) {
  return static_cast<int>(table.integer_or(key, fallback, allowed));
}

ParameterSpace read_space(const TomlTable& root, const std::vector<std::string>& known,
                          const std::vector<std::string>& kpis) {
  auto [ties, sources, fixed] = read_ties_and_fixed(root, known);
  const auto parameters = root.table("parameters");
  std::vector<Parameter> free;
  for (const auto& name : parameters.keys()) {
    for (const auto& wrong : {unusable_name(name, kpis), unknown_name(name, known, sources)})
      if (!wrong.empty()) parameters.fail(name, wrong);
    free.push_back(read_parameter(parameters, name));
    if (free.back().kind != ParameterKind::continuous)
      parameters.fail(name,
                      "a study calibrates continuous parameters; give it lower and upper, or "
                      "fix it");
  }
  if (free.size() < kFewestFactors || free.size() > kMostFactors)
    parameters.fail("", fmt::format("there are {} parameters; a screening needs {} to {}",
                                    free.size(), kFewestFactors, kMostFactors));
  try {
    return ParameterSpace(std::move(free), std::move(fixed), std::move(ties));
  } catch (const InputError& error) {
    parameters.fail("", error.what());
  }
}

std::vector<MeasuredTarget> read_targets(const TomlTable& root,
                                         const std::vector<std::string>& kpis) {
  const auto table = root.table("targets");
  std::vector<MeasuredTarget> targets;
  for (const auto& name : table.keys()) {
    if (std::find(kpis.begin(), kpis.end(), name) == kpis.end())
      table.fail(name,
                 fmt::format("the scenario has no KPI of this name; it has {}", listed(kpis)));
    const auto t = table.table(name);
    MeasuredTarget target;
    target.target.name = name;
    target.target.value = t.number("value");
    target.ci95 = t.number_or("ci95", 0.0, kNonNegative);
    target.target.weight = t.number_or("weight", 1.0, kPositive);
    if (t.has("scale")) target.target.scale = t.number("scale", kPositive);
    if (target.target.value == 0.0 && target.target.scale == 0.0)
      t.fail("value", "0 has no relative error; give the target a scale");
    targets.push_back(std::move(target));
  }
  if (targets.empty()) table.fail("", "there is no target; give at least one");
  double sum = 0.0;
  for (const auto& t : targets) sum += t.target.weight;
  for (auto& t : targets) {
    t.target.weight /= sum;  // Eq. 5.7 of [Hadi2026]: weights sum to 1
    if (t.target.scale == 0.0) t.target.scale = std::abs(t.target.value);
  }
  return targets;
}

void read_plans(const TomlTable& root, Study& study) {
  if (const auto t = root.table_if_present("screening")) {
    auto& plan = study.screening;
    plan.repetitions = count(*t, "repetitions", plan.repetitions, kAtLeastOne);
    plan.fake_factors = count(*t, "fake_factors", plan.fake_factors, {.lower = 0, .upper = 20});
    plan.analysis.alpha =
        t->number_or("alpha", plan.analysis.alpha,
                     {.lower = 0, .upper = 1, .open_lower = true, .open_upper = true});
    plan.analysis.vote_share = t->number_or("vote", plan.analysis.vote_share, kShare);
    if (t->choice_or("method", "stepwise", {"stepwise", "fit-dsd"}) == "fit-dsd")
      plan.analysis.method = doe::ScreeningOptions::Method::fit_dsd;
    if (t->choice_or("terms", "main", {"main", "second-order"}) == "second-order") {
      plan.analysis.candidates = doe::CandidateTerms::main_and_second_order;
      plan.analysis.direction = doe::StepDirection::mixed;  // more candidates than runs
    }
  }
  if (const auto t = root.table_if_present("sampling")) {
    auto& plan = study.sampling;
    plan.points_per_parameter =
        count(*t, "points_per_parameter", plan.points_per_parameter, kAtLeastOne);
    plan.repetitions = count(*t, "repetitions", plan.repetitions, kAtLeastOne);
    plan.use_screening_runs = t->flag_or("use_screening_runs", plan.use_screening_runs);
  }
  if (const auto t = root.table_if_present("adaptive")) {
    auto& plan = study.adaptive;
    plan.batch = count(*t, "batch", plan.batch, kAtLeastOne);
    plan.max_batches = count(*t, "max_batches", plan.max_batches, {.lower = 0, .upper = 1e6});
    plan.r2 = t->number_or("r2", plan.r2, {.lower = 0, .upper = 1});
  }
  if (const auto t = root.table_if_present("surrogate")) {
    std::vector<std::string> kernels;
    for (const auto kernel : surrogate::all_kernels()) kernels.emplace_back(to_string(kernel));
    study.surrogate.kernel =
        surrogate::kernel_named(t->choice_or("kernel", "ard-matern52", kernels));
    study.surrogate.basis = surrogate::basis_named(
        t->choice_or("basis", "constant", {"none", "constant", "linear", "quadratic"}));
    study.surrogate.starts = count(*t, "starts", study.surrogate.starts, kAtLeastOne);
  }
  if (const auto t = root.table_if_present("optimiser")) {
    auto& ga = study.genetic;
    ga.population = count(*t, "population", ga.population, {.lower = 4, .upper = 1e6});
    ga.max_generations = count(*t, "max_generations", ga.max_generations, kAtLeastOne);
    ga.crossover_probability =
        t->number_or("crossover_probability", ga.crossover_probability, {.lower = 0, .upper = 1});
    ga.mutation_probability =
        t->number_or("mutation_probability", ga.mutation_probability, {.lower = 0, .upper = 1});
    ga.function_tolerance = t->number_or("function_tolerance", ga.function_tolerance, kNonNegative);
  }
  if (const auto t = root.table_if_present("verification"))
    study.verification.repetitions =
        count(*t, "repetitions", study.verification.repetitions, kAtLeastOne);
}

/// A study whose simulations cannot be built is refused before any of them runs: the middle of the
/// space is tried, then each parameter alone at its ends.
void check_cases(const Study& study, const TomlTable& root) {
  const auto parameters = root.table("parameters");
  const auto d = static_cast<Eigen::Index>(study.space.dimension());
  const auto build = [&](const Vector& unit) {
    static_cast<void>(
        study.scenario.make_input(study.space.complete(study.space.from_unit(unit)), 0));
  };
  try {
    build(Vector::Constant(d, 0.5));
  } catch (const InputError& error) {
    root.fail("", fmt::format("with every parameter at its middle: {}", error.what()));
  }
  for (Eigen::Index i = 0; i < d; ++i)
    for (const double end : {0.0, 1.0}) {
      const auto& p = study.space.parameters()[static_cast<std::size_t>(i)];
      Vector unit = Vector::Constant(d, 0.5);
      unit[i] = end;
      try {
        build(unit);
      } catch (const InputError& error) {
        parameters.fail(p.name,
                        fmt::format("with {} = {}: {}", p.name,
                                    shortest(end == 0.0 ? p.lower : p.upper), error.what()));
      }
    }
}

}  // namespace

std::vector<opt::Target> Study::plain_targets() const {
  std::vector<opt::Target> plain;
  for (const auto& t : targets) plain.push_back(t.target);
  return plain;
}

Study read_study(const std::filesystem::path& path) {
  const auto root = TomlTable::read_file(path);
  Study study{.title = root.text_or("title", path.stem().string()),
              .scenario = read_scenario_key(root, path.parent_path()),
              .seed = static_cast<std::uint64_t>(root.integer_or("seed", 1, {.lower = 0.0})),
              .seeds = read_seeds(root)};
  study.space = read_space(root, study.scenario.parameter_names(), study.scenario.kpi_names());
  study.targets = read_targets(root, study.scenario.kpi_names());
  read_plans(root, study);
  study.engine = read_engine_choice(root, path.parent_path());
  study.compute = read_compute_plan(root, path.parent_path());
  study.failures = read_failure_policy(root, study.scenario.kpi_names());
  root.refuse_unknown_keys();
  check_cases(study, root);
  return study;
}

RunCounts planned_runs(const Study& study) {
  const auto k = static_cast<int>(study.space.dimension());
  const auto design =
      doe::definitive_screening_design(k, {.fake_factors = study.screening.fake_factors});
  return {
      .screening = static_cast<int>(design.coded.rows()) * study.screening.repetitions,
      .sampling = k * study.sampling.points_per_parameter * study.sampling.repetitions,
      .adaptive = study.adaptive.batch * study.adaptive.max_batches * study.sampling.repetitions,
      .verification = 2 * study.verification.repetitions};
}

}  // namespace repose::dem_adapter
