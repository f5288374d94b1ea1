#include <fmt/format.h>

#include "model_names.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using table::Table;
using State = ModelAccess::State;
using namespace model_names;

template <class Vectorlike>
std::vector<double> doubles(const Vectorlike& values) {
  std::vector<double> v(static_cast<std::size_t>(values.size()));
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = values[static_cast<Eigen::Index>(i)];
  return v;
}

void add(Table& table, std::string name, table::Values values) {
  table.add({.name = std::move(name), .values = std::move(values)});
}

table::Attributes file_attributes(const NamedModel& named) {
  const State& s = ModelAccess::state(named.model);
  return {{"repose_model", std::string(kModel)},
          {"model_version", kVersion},
          {"response", named.response},
          {"response_scale", std::string(to_string(s.data.response_scale))},
          {"kernel", std::string(to_string(named.model.kernel()))},
          {"alpha", s.covariance.alpha},
          {"noise", std::string(to_string(s.noise))},
          {"basis", std::string(to_string(s.data.trend.basis))},
          {"estimator", std::string(to_string(s.estimator))},
          {"shift", s.data.shift},
          {"scale", s.data.scale},
          {"within", s.data.within},
          {"log_repeats", s.data.log_repeats},
          {"log_jacobian", s.data.log_jacobian},
          {"amplitude", s.amplitude},
          {"noise_ratio", s.covariance.noise_ratio},
          {"jitter", s.factor.jitter},
          {"variance_factor", s.parameters.variance_factor},
          {"uncertain_directions", static_cast<std::int64_t>(s.parameters.root.cols())},
          {"fit_termination", std::string(to_string(s.report.termination))},
          {"fit_message", s.report.message},
          {"fit_evaluations", static_cast<std::int64_t>(s.report.evaluations)},
          {"fit_instruction_set", s.report.instruction_set},
          {"fit_seconds", s.report.seconds}};
}

Table inputs_table(const Encoding& encoding, const std::vector<std::string>& names) {
  std::vector<double> lower;
  std::vector<double> upper;
  std::vector<std::string> scale;
  std::vector<std::string> coding;
  std::vector<std::int64_t> levels;
  for (const Input& input : encoding.inputs()) {
    lower.push_back(input.lower);
    upper.push_back(input.upper);
    scale.emplace_back(input.scale == Scale::log ? "log" : "linear");
    coding.emplace_back(to_string(input.coding));
    levels.push_back(static_cast<std::int64_t>(input.levels.size()));
  }
  Table t;
  add(t, "name", names);
  add(t, "lower", lower);
  add(t, "upper", upper);
  add(t, "scale", scale);
  add(t, "levels", levels);
  add(t, "coding", coding);
  return t;
}

/// Of all categories, one after another.
Table levels_table(const Encoding& encoding, const std::vector<std::string>& names) {
  std::vector<std::string> input;
  std::vector<std::string> level;
  for (std::size_t k = 0; k < names.size(); ++k)
    for (const std::string& name : encoding.inputs()[k].levels) {
      input.push_back(names[k]);
      level.push_back(name);
    }
  Table t;
  add(t, "input", input);
  add(t, "level", level);
  return t;
}

Table scales_table(const State& s) {
  Table t;
  add(t, "name", s.data.encoding.scale_names());
  add(t, "length_scale", doubles(s.covariance.length_scales));
  return t;
}

Table trend_table(const State& s, const GaussianProcess& model) {
  Table t;
  add(t, "name", trend_names(s.data.trend, s.data.encoding));
  add(t, "coefficient", doubles(model.coefficients()));
  return t;
}

Table functions_table(const std::vector<std::string>& names) {
  Table t;
  add(t, "name", names);
  return t;
}

Table points_table(const Dataset& data) {
  Table t;
  for (Eigen::Index k = 0; k < data.dimension(); ++k)
    add(t, natural_column(k), doubles(data.natural.col(k)));
  for (Eigen::Index p = 0; p < data.x.cols(); ++p)
    add(t, encoded_column(p), doubles(data.x.col(p)));
  add(t, "y", doubles(data.y));
  add(t, "noise", doubles(data.noise));
  return t;
}

Table rows_table(const Dataset& data) {
  Table t;
  add(t, "point", std::vector<std::int64_t>(data.point_of_row.begin(), data.point_of_row.end()));
  add(t, "y", data.value_of_row);
  add(t, "noise", data.noise_of_row);
  return t;
}

Table factor_table(const Matrix& l) {
  std::vector<double> packed;
  for (Eigen::Index j = 0; j < l.cols(); ++j)
    for (Eigen::Index i = j; i < l.rows(); ++i) packed.push_back(l(i, j));
  Table t;
  add(t, "l", std::move(packed));
  return t;
}

/// A row a parameter that shapes the covariance, a column an independent direction.
Table uncertainty_table(const State& s) {
  Table t;
  for (Eigen::Index k = 0; k < s.parameters.root.cols(); ++k)
    add(t, root_column(k), doubles(s.parameters.root.col(k)));
  return t;
}

Table parameters_table(const std::vector<FittedParameter>& parameters) {
  std::vector<std::string> name;
  std::vector<std::string> state;
  std::vector<double> value;
  std::vector<double> lower;
  std::vector<double> upper;
  std::vector<double> relevance;
  for (const FittedParameter& p : parameters) {
    name.push_back(p.name);
    value.push_back(p.value);
    lower.push_back(p.lower);
    upper.push_back(p.upper);
    state.emplace_back(to_string(p.state));
    relevance.push_back(p.relevance);
  }
  Table t;
  add(t, "name", name);
  add(t, "value", value);
  add(t, "lower", lower);
  add(t, "upper", upper);
  add(t, "state", state);
  add(t, "relevance", relevance);
  return t;
}

}  // namespace

void save_model(const std::filesystem::path& path, const NamedModel& model) {
  const State& s = ModelAccess::state(model.model);
  if (static_cast<Eigen::Index>(model.inputs.size()) != model.model.dimension())
    throw InputError(fmt::format("{} input names for a model of {} inputs", model.inputs.size(),
                                 model.model.dimension()));
  std::vector<std::pair<std::string, Table>> tables{
      {"/inputs", inputs_table(s.data.encoding, model.inputs)},
      {"/length_scales", scales_table(s)},
      {"/points", points_table(s.data)},
      {"/rows", rows_table(s.data)},
      {"/factor", factor_table(s.factor.l)}};
  const auto add_if_any = [&tables](const char* name, Table t) {
    if (t.rows() > 0) tables.emplace_back(name, std::move(t));
  };
  add_if_any("/levels", levels_table(s.data.encoding, model.inputs));
  add_if_any("/trend", trend_table(s, model.model));
  add_if_any("/functions", functions_table(s.data.trend.functions.names));
  add_if_any("/parameter_uncertainty", uncertainty_table(s));
  add_if_any("/parameters", parameters_table(s.report.parameters));
  table::write_tables(path, tables, file_attributes(model));
}

}  // namespace repose::surrogate
