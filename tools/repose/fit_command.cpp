// repose fit: a surrogate of one column of a table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct FitOptions {
  CommonOptions common;
  std::string table;
  std::string response;
  std::vector<std::string> inputs;
  std::string model = "gpr";
  std::string kernel = "ard-matern52";
  std::string noise = "estimated";
  std::string estimator = "reml";
  std::string output;
  int starts = 5;
  std::uint64_t seed = 1;
};

/// Columns named on the command line, or those with the role factor, or all numbers but the
/// response.
std::vector<std::string> inputs_of(const table::Table& table, const FitOptions& options) {
  if (!options.inputs.empty()) return options.inputs;
  auto names = table.names_with_role(table::Role::factor);
  if (names.empty())
    for (const auto& c : table.columns())
      if (c.role == table::Role::none && c.name != options.response &&
          !std::holds_alternative<std::vector<std::string>>(c.values))
        names.push_back(c.name);
  if (names.empty())
    throw InputError("the table has no column to predict from; name them with --input");
  return names;
}

/// The declared ranges of the inputs, or those of the data where none is declared.
opt::Bounds ranges_of(const table::Table& table, const std::vector<std::string>& inputs,
                      const Matrix& x) {
  const auto d = static_cast<Eigen::Index>(inputs.size());
  opt::Bounds bounds{Vector(d), Vector(d)};
  for (Eigen::Index k = 0; k < d; ++k) {
    const auto& column = table.column(inputs[static_cast<std::size_t>(k)]);
    bounds.lower[k] = column.range ? column.range->lower : x.col(k).minCoeff();
    bounds.upper[k] = column.range ? column.range->upper : x.col(k).maxCoeff();
    if (!(bounds.lower[k] < bounds.upper[k]))
      throw InputError(
          fmt::format("column {} is {} in every row: nothing can be learnt from it; leave it out "
                      "by naming the others with --input",
                      column.name, shortest(bounds.lower[k])));
  }
  return bounds;
}

/// Rows in which the response is not missing.
table::Table usable_rows(const table::Table& table, const std::string& response) {
  const auto y = table.numbers(response);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < y.size(); ++i)
    if (!std::isnan(y[i])) rows.push_back(i);
  if (rows.empty()) throw InputError(fmt::format("column {} has no value", response));
  return table.selected_rows(rows);
}

void print_fit(const surrogate::NamedModel& named, const FitOptions& options) {
  const auto& model = named.model;
  const auto& report = model.report();
  const auto loo = model.leave_one_out();
  if (options.common.json) {
    nlohmann::json parameters = nlohmann::json::array();
    for (const auto& p : report.parameters)
      parameters.push_back({{"name", p.name},
                            {"value", p.value},
                            {"state", to_string(p.state)},
                            {"relevance", p.relevance}});
    fmt::print("{}\n",
               nlohmann::json{{"response", named.response},
                              {"inputs", named.inputs},
                              {"rows", model.rows()},
                              {"negative_log_likelihood", model.negative_log_likelihood()},
                              {"parameters", parameters},
                              {"noise_standard_deviation", std::sqrt(model.noise_variance())},
                              {"loo_q2", loo.q2},
                              {"loo_rmse", loo.rmse},
                              {"loo_coverage95", loo.coverage95},
                              {"evaluations", report.evaluations},
                              {"seconds", report.seconds},
                              {"message", report.message},
                              {"file", options.output}}
                   .dump(2));
    return;
  }
  fmt::print("{} of {} rows and {} inputs, {}, {:.2f} s\n\n", named.response, model.rows(),
             named.inputs.size(), to_string(model.kernel()), report.seconds);
  for (std::size_t i = 0; i < report.parameters.size(); ++i) {
    const auto& p = report.parameters[i];
    const auto label = i < named.inputs.size() ? "length scale of " + named.inputs[i] : p.name;
    fmt::print("  {:<40} {:>12.5g}  {}\n", label, p.value, to_string(p.state));
  }
  fmt::print("  {:<40} {:>12.5g}\n", "standard deviation of the noise",
             std::sqrt(model.noise_variance()));
  fmt::print("  {:<40} {:>12.5g}\n", "negative log likelihood", model.negative_log_likelihood());
  fmt::print("  {:<40} {:>12.4f}\n", "left-out rows: Q2", loo.q2);
  fmt::print("  {:<40} {:>12.5g}\n", "left-out rows: root mean square error", loo.rmse);
  fmt::print("  {:<40} {:>11.0f}%\n", "left-out rows: inside their 95 % interval",
             100.0 * loo.coverage95);
  fmt::print("\nwritten to {}\n", options.output);
}

void fit(const FitOptions& options) {
  const auto table =
      usable_rows(table::read_table(table::parse_location(options.table), table::Missing::allow),
                  options.response);
  const auto inputs = inputs_of(table, options);
  const Matrix x = table.matrix(inputs);
  const auto y = table.numbers(options.response);
  surrogate::GaussianProcessOptions gp;
  gp.kernel = surrogate::kernel_named(options.kernel);
  gp.noise = options.noise == "none" ? surrogate::Noise::none : surrogate::Noise::estimated;
  gp.estimator = options.estimator == "ml" ? surrogate::Estimator::ml : surrogate::Estimator::reml;
  if (gp.estimator == surrogate::Estimator::ml) gp.prior = surrogate::Prior::none;
  gp.starts = options.starts;
  gp.seed = options.seed;
  gp.threads = 0;
  const surrogate::NamedModel named{
      surrogate::GaussianProcess::fit(
          x, Eigen::Map<const Vector>(y.data(), static_cast<Eigen::Index>(y.size())),
          ranges_of(table, inputs, x), gp),
      inputs, options.response};
  surrogate::save_model(options.output, named);
  print_fit(named, options);
}

}  // namespace

void add_fit(CLI::App& app) {
  auto o = std::make_shared<FitOptions>();
  auto* command =
      add_command(app, "fit", "Fits a surrogate of one column of a table",
                  "repose fit quick/runs.h5 --response shear_angle_deg -o shear.h5", o->common);
  command->add_option("TABLE", o->table, "FILE.h5, FILE.h5:/group or FILE.csv")->required();
  command->add_option("--response", o->response, "column to predict")->required();
  command
      ->add_option("--input", o->inputs,
                   "columns to predict from; the table's factors unless given")
      ->delimiter(',');
  command->add_option("--model", o->model, "gpr: Gaussian process regression")
      ->capture_default_str()
      ->check(CLI::IsMember({"gpr"}));
  command->add_option("--kernel", o->kernel, "ard-matern52 or ard-squared-exponential")
      ->capture_default_str()
      ->check(CLI::IsMember({"ard-matern52", "ard-squared-exponential"}));
  command->add_option("--noise", o->noise, "estimated or none")
      ->capture_default_str()
      ->check(CLI::IsMember({"estimated", "none"}));
  command->add_option("--estimator", o->estimator, "reml, with the jointly robust prior, or ml")
      ->capture_default_str()
      ->check(CLI::IsMember({"reml", "ml"}));
  command->add_option("--starts", o->starts, "of the likelihood's search")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  command->add_option("--seed", o->seed)->capture_default_str();
  command->add_option("-o,--output", o->output, "model file to write")->required();
  command->callback([o] { fit(*o); });
}

}  // namespace repose::cli
