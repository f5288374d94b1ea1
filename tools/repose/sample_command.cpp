// repose sample: where to simulate next, by fitted models.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "model_set.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/propose.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct SampleOptions {
  CommonOptions common;
  ModelSetOptions models;
  std::string acquisition = "ei";
  std::string belief = "kriging";
  std::string repeats = "avoid";
  std::string pending;
  std::string failed;
  std::string output;
  double kappa = 2.0;
  double minimum_distance = 1e-3;
  int batch = 1;
  std::uint64_t seed = 1;
};

opt::Acquisition acquisition_of(const SampleOptions& options) {
  // expected improvement is always maximised by its logarithm, and of a composite of the targets
  if (options.acquisition == "composite-ei" && options.models.targets.empty())
    throw InputError("--acquisition composite-ei needs a --target for every model");
  if (options.acquisition == "log-ei" || options.acquisition == "composite-ei")
    return opt::Acquisition::expected_improvement;
  return named(options.acquisition, {opt::Acquisition::expected_improvement,
                                     opt::Acquisition::noisy_expected_improvement,
                                     opt::Acquisition::lower_confidence_bound});
}

Matrix points_in(const ModelSet& models, const std::string& file) {
  if (file.empty()) return Matrix(0, models.space().dimension());
  return models
      .points_of(table::read_table(table::parse_location(file), table::Missing::allow), file)
      .coordinates;
}

opt::Proposal proposal_of(const ModelSet& models, const SampleOptions& options) {
  opt::ProposeOptions propose{
      .visited = models.known().coordinates,
      .pending = points_in(models, options.pending),
      .failed = points_in(models, options.failed),
      .acquisition = acquisition_of(options),
      .kappa = options.kappa,
      .belief = named(options.belief, {opt::Belief::kriging, opt::Belief::best_lie,
                                       opt::Belief::mean_lie, opt::Belief::worst_lie}),
      .repeats = named(options.repeats,
                       {opt::Repeats::avoid, opt::Repeats::allow, opt::Repeats::deliberate}),
      .minimum_distance = options.minimum_distance,
      .seed = derive_seed(options.seed, static_cast<std::uint64_t>(models.known().natural.rows())),
      .threads = 0};
  if (models.targets().empty())
    return opt::propose_batch(models.surrogates()[0], models.space().set(), options.batch, propose);
  return opt::propose_batch(models.surrogates(), models.targets(), models.space().set(),
                            options.batch, propose);
}

/// Natural values; those of a repeat to the bit.
Matrix natural_points(const ModelSet& models, const opt::Proposal& proposal) {
  Matrix natural = models.space().natural_rows(proposal.points);
  const Points& known = models.known();
  for (Eigen::Index i = 0; i < natural.rows(); ++i)
    for (Eigen::Index k = 0; k < known.natural.rows(); ++k)
      if (known.coordinates.row(k) == proposal.points.row(i)) natural.row(i) = known.natural.row(k);
  return natural;
}

table::Table table_of(const ModelSet& models, const opt::Proposal& proposal,
                      const SampleOptions& options) {
  table::Table table = models.runs(natural_points(models, proposal));
  std::vector<double> promised;
  std::vector<std::int64_t> repeat;
  const bool bound = acquisition_of(options) == opt::Acquisition::lower_confidence_bound;
  const double sign = models.maximises() ? 1.0 : -1.0;  // a bound in the response's own sign
  for (std::size_t i = 0; i < proposal.merit.size(); ++i) {
    promised.push_back(bound ? sign * proposal.merit[i] : std::exp(proposal.merit[i]));
    repeat.push_back(proposal.repeat[i] ? 1 : 0);
  }
  table.add({.name = bound ? "confidence_bound" : "expected_improvement",
             .range = {},
             .values = promised});
  table.add({.name = "repeat", .range = {}, .values = repeat});
  return table;
}

nlohmann::json to_json(const table::Table& table, const ModelSet& models, Eigen::Index known,
                       const std::string& file) {
  nlohmann::json points = nlohmann::json::array();
  for (std::size_t i = 0; i < table.rows(); ++i) {
    nlohmann::json point;
    for (const auto& column : table.columns())
      std::visit([&](const auto& values) { point[column.name] = values[i]; }, column.values);
    points.push_back(point);
  }
  return {{"objective", models.objective_name()},
          {"known_points", known},
          {"points", points},
          {"file", file}};
}

std::string cell(const table::Values& values, std::size_t i) {
  if (const auto* text = std::get_if<std::vector<std::string>>(&values)) return (*text)[i];
  if (const auto* whole = std::get_if<std::vector<std::int64_t>>(&values))
    return fmt::format("{}", (*whole)[i]);
  return fmt::format("{:.5g}", std::get<std::vector<double>>(values)[i]);
}

void print_text(const table::Table& table, const ModelSet& models, Eigen::Index known,
                const std::string& file) {
  fmt::print("{} to {}: {}\n",
             table.rows() == 1 ? "1 point" : fmt::format("{} points", table.rows()),
             models.maximises() ? "raise" : "lower", models.objective_name());
  if (known == 0)
    fmt::print(
        "no run of the models lies in this space; if there are any, name them with --runs\n");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    fmt::print("\n");
    for (const auto& column : table.columns())
      fmt::print("  {:<44} {:>14}{}\n", column.name, cell(column.values, i),
                 column.unit == "1" ? "" : " " + column.unit);
  }
  fmt::print("\nwritten to {}\n", file);
}

void sample(const SampleOptions& options) {
  const ModelSet models(options.models);
  models.refuse_names({"run", "repeat", "confidence_bound", "expected_improvement"});
  const auto proposal = proposal_of(models, options);
  auto table = table_of(models, proposal, options);
  std::vector<std::string> parents = options.models.models;
  for (const auto& file :
       {options.models.factors, options.models.runs, options.pending, options.failed})
    if (!file.empty()) parents.push_back(file);
  table::stamp_provenance(table, command_line(), options.seed, parents);
  table::write_table(table::parse_location(options.output), table);
  const Eigen::Index known = models.known().natural.rows();
  if (std::any_of(proposal.merit.begin(), proposal.merit.end(),
                  [](double merit) { return std::isinf(merit); }))
    fmt::print(stderr,
               "repose: nothing promises improvement, or every point is known or near a failed "
               "one\n");
  if (options.common.json)
    fmt::print("{}\n", to_json(table, models, known, options.output).dump(2));
  else
    print_text(table, models, known, options.output);
}

}  // namespace

void add_sample(CLI::App& app) {
  auto o = std::make_shared<SampleOptions>();
  auto* command =
      add_command(app, "sample", "Proposes the next points to simulate",
                  "repose sample angle.h5 mass.h5 --target angle_deg=38 --target mass_kg=1.4 "
                  "-o next.h5",
                  o->common);
  add_model_set_options(*command, o->models);
  command
      ->add_option("--acquisition", o->acquisition,
                   "ei (or log-ei, composite-ei), nei (noisy runs), lcb")
      ->capture_default_str()
      ->check(CLI::IsMember({"ei", "log-ei", "composite-ei", "nei", "lcb"}).description(""));
  command->add_option("--kappa", o->kappa, "of lcb, a confidence bound: standard deviations")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  command->add_option("--batch", o->batch, "points")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  command->add_option("--belief", o->belief, "of points under way")
      ->capture_default_str()
      ->check(CLI::IsMember({"kriging", "best-lie", "mean-lie", "worst-lie"}));
  command->add_option("--repeats", o->repeats, "deliberate: where that tells more than a new point")
      ->capture_default_str()
      ->check(CLI::IsMember({"avoid", "allow", "deliberate"}));
  command->add_option("--minimum-distance", o->minimum_distance, "of points, of the range")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--pending", o->pending, "table of points being simulated");
  command->add_option("--failed", o->failed, "table of points whose simulation failed");
  command->add_option("--seed", o->seed)->capture_default_str();
  command->add_option("-o,--output", o->output, "table to write (.h5 or .csv)")->required();
  command->callback([o, command] {
    if (o->acquisition != "lcb") refuse_options(*command, {"--kappa"}, "without --acquisition lcb");
    sample(*o);
  });
}

}  // namespace repose::cli
