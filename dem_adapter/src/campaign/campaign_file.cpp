#include "repose/dem_adapter/campaign_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "outcome_columns.hpp"
#include "parameter_tables.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"
#include "repose/table/writer.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::uint64_t kCampaignStream = 500;
constexpr std::size_t kBlock = 1000;  // rows in memory

/// Factors, or where no column is one (CSV) all columns of numbers.
std::vector<std::string> parameter_columns(const table::Table& table) {
  auto names = table.names_with_role(table::Role::factor);
  if (!names.empty()) return names;
  for (const auto& column : table.columns())
    if (column.role == table::Role::none &&
        !std::holds_alternative<std::vector<std::string>>(column.values))
      names.push_back(column.name);
  return names;
}

table::Table read_points(const TomlTable& root, const std::filesystem::path& directory,
                         const Scenario& scenario, const TiesAndFixed& others) {
  table::Table points;
  if (!root.has("points")) return points;
  auto location = table::parse_location(root.text("points"));
  location.file = directory / location.file;
  const auto table = table::read_table(location);
  for (const auto& name : parameter_columns(table)) {
    for (const auto& wrong : {unusable_name(name, scenario.kpi_names()),
                              unknown_name(name, scenario.parameter_names(), others.sources)})
      if (!wrong.empty())
        root.fail("points",
                  fmt::format("column {} of {}: {}", name, table::location_text(location), wrong));
    table::Column column = table.column(name);
    column.role = table::Role::factor;
    column.values = table.numbers(name);  // a text is refused here
    points.add(std::move(column));
  }
  if (points.columns().empty() || points.rows() == 0)
    root.fail("points", fmt::format("{} has {}; give a table with one row a point",
                                    table::location_text(location),
                                    points.columns().empty() ? "no parameters" : "no rows"));
  return points;
}

}  // namespace

CampaignFile read_campaign(const std::filesystem::path& directory) {
  const auto path = directory / "campaign.toml";
  if (!std::filesystem::exists(path))
    throw StorageError(fmt::format(
        "there is no '{}'; write one (docs/how-to/campaign.md). A calibration goes on with repose "
        "calibrate",
        path.string()));
  const auto root = TomlTable::read_file(path);
  CampaignFile file{.title = root.text_or("title", directory.filename().string()),
                    .scenario = read_scenario_key(root, directory),
                    .seed = static_cast<std::uint64_t>(root.integer_or("seed", 1, kNonNegative)),
                    .repetitions = static_cast<int>(
                        root.integer_or("repetitions", 1, {.lower = 1, .upper = 1e6})),
                    .seeds = read_seeds(root)};
  auto others = read_ties_and_fixed(root, file.scenario.parameter_names());
  file.points = read_points(root, directory, file.scenario, others);
  file.fixed = std::move(others.fixed);
  file.ties = std::move(others.ties);
  file.engine = read_engine_choice(root, directory);
  file.compute = read_compute_plan(root, directory);
  file.failures = read_failure_policy(root, file.scenario.kpi_names());
  root.refuse_unknown_keys();
  static_cast<void>(file.make_input(0));
  return file;
}

std::size_t CampaignFile::runs() const {
  return std::max<std::size_t>(1, points.rows()) * static_cast<std::size_t>(repetitions);
}

RunInput CampaignFile::make_input(std::size_t run, int attempt) const {
  const auto point = point_of(run);
  ParameterValues values = fixed;
  for (const auto& column : points.columns())
    values[column.name] = std::get<std::vector<double>>(column.values)[point];
  const auto of_campaign = derive_seed(seed, kCampaignStream);
  const auto of_point = seeds == Seeds::common ? of_campaign : derive_seed(of_campaign, point);
  try {
    return scenario.make_input(
        ParameterSpace({}, std::move(values), ties).complete(Vector(0)),
        attempt_seed(derive_seed(of_point, static_cast<std::uint64_t>(repetition_of(run))),
                     attempt));
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("point {} of the campaign cannot be simulated: {}", point + 1, error.what()));
  }
}

WantedRuns CampaignFile::wanted_runs() const {
  return {.count = runs(),
          .make_input = [this](std::size_t run, int attempt) { return make_input(run, attempt); }};
}

std::size_t write_campaign_table(const std::filesystem::path& file, const CampaignFile& campaign,
                                 const RunPlan& plan, const RunStore& store,
                                 const std::string& command_line) {
  std::vector<std::int64_t> point, repetition;
  std::vector<std::vector<double>> parameters(campaign.points.columns().size());
  OutcomeColumns outcomes(campaign.scenario.kpi_names());
  const auto block = [&] {
    using table::Role;
    table::Table rows;
    rows.add({.name = "point", .role = Role::id, .values = std::exchange(point, {})});
    rows.add(
        {.name = "repetition", .role = Role::replicate, .values = std::exchange(repetition, {})});
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      table::Column column = campaign.points.columns()[k];
      column.values = std::exchange(parameters[k], {});
      rows.add(std::move(column));
    }
    outcomes.add_to(rows);
    return rows;
  };
  auto header = block();
  table::stamp_provenance(header, command_line, campaign.seed, {"campaign.toml"});
  table::TableWriter writer({file, ""}, header);
  const auto find = [&](const std::string& key) { return store.find(key); };
  for (std::size_t run = 0; run < std::min(campaign.runs(), plan.runs.size()); ++run) {
    auto outcome = settled(plan.runs[run], plan.retry_on, find);
    if (!outcome) continue;
    if (run_key(outcome->engine, campaign.make_input(run).text) != plan.runs[run].front())
      throw InputError(fmt::format(
          "campaign.toml or its points changed since the campaign was run: run {} is another one "
          "now; call repose campaign run, which does only what is new",
          run + 1));
    if (outcome->failed()) outcome->measurement.kpis = campaign.failures.penalty;
    point.push_back(static_cast<std::int64_t>(campaign.point_of(run)) + 1);
    repetition.push_back(campaign.repetition_of(run) + 1);
    for (std::size_t k = 0; k < parameters.size(); ++k)
      parameters[k].push_back(std::get<std::vector<double>>(
          campaign.points.columns()[k].values)[campaign.point_of(run)]);
    outcomes.add(*outcome);
    if (point.size() == kBlock) writer.append(block());
  }
  if (!point.empty()) writer.append(block());
  const auto rows = writer.rows();
  writer.finish();
  return rows;
}

}  // namespace repose::dem_adapter
