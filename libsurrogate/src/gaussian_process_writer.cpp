#include "gaussian_process_file.hpp"
#include "model_kinds.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using table::Table;
using State = ModelAccess::State;
using namespace model_names;

table::Attributes attributes_of(const GaussianProcess& model) {
  const State& s = ModelAccess::state(model);
  return {{"response_scale", std::string(to_string(s.data.response_scale))},
          {"kernel", std::string(to_string(model.kernel()))},
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

Table scales_table(const State& s) {
  Table t;
  add_column(t, "name", s.data.encoding.scale_names());
  add_column(t, "length_scale", doubles(s.covariance.length_scales));
  return t;
}

Table trend_table(const State& s, const GaussianProcess& model) {
  Table t;
  add_column(t, "name", trend_names(s.data.trend, s.data.encoding));
  add_column(t, "coefficient", doubles(model.coefficients()));
  return t;
}

Table functions_table(const std::vector<std::string>& names) {
  Table t;
  add_column(t, "name", names);
  return t;
}

Table points_table(const Dataset& data) {
  Table t;
  for (Eigen::Index k = 0; k < data.dimension(); ++k)
    add_column(t, natural_column(k), doubles(data.natural.col(k)));
  for (Eigen::Index p = 0; p < data.x.cols(); ++p)
    add_column(t, encoded_column(p), doubles(data.x.col(p)));
  add_column(t, "y", doubles(data.y));
  add_column(t, "noise", doubles(data.noise));
  return t;
}

Table rows_table(const Dataset& data) {
  Table t;
  add_column(t, "point",
             std::vector<std::int64_t>(data.point_of_row.begin(), data.point_of_row.end()));
  add_column(t, "y", data.value_of_row);
  add_column(t, "noise", data.noise_of_row);
  return t;
}

Table factor_table(const Matrix& l) {
  std::vector<double> packed;
  for (Eigen::Index j = 0; j < l.cols(); ++j)
    for (Eigen::Index i = j; i < l.rows(); ++i) packed.push_back(l(i, j));
  Table t;
  add_column(t, "l", std::move(packed));
  return t;
}

/// A row a parameter that shapes the covariance, a column an independent direction.
Table uncertainty_table(const State& s) {
  Table t;
  for (Eigen::Index k = 0; k < s.parameters.root.cols(); ++k)
    add_column(t, root_column(k), doubles(s.parameters.root.col(k)));
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
  add_column(t, "name", name);
  add_column(t, "value", value);
  add_column(t, "lower", lower);
  add_column(t, "upper", upper);
  add_column(t, "state", state);
  add_column(t, "relevance", relevance);
  return t;
}

}  // namespace

std::optional<ModelContent> write_gaussian_process(const Regressor& regressor) {
  const GaussianProcess* model = gaussian_process(regressor);
  if (model == nullptr) return std::nullopt;
  const State& s = ModelAccess::state(*model);
  ModelContent content{.attributes = attributes_of(*model)};
  content.add("/length_scales", scales_table(s));
  content.add("/points", points_table(s.data));
  content.add("/rows", rows_table(s.data));
  content.add("/factor", factor_table(s.factor.l));
  content.add("/trend", trend_table(s, *model));
  content.add("/functions", functions_table(s.data.trend.functions.names));
  content.add("/parameter_uncertainty", uncertainty_table(s));
  content.add("/parameters", parameters_table(s.report.parameters));
  return content;
}

}  // namespace repose::surrogate
