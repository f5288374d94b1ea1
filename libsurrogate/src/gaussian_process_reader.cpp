#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "gaussian_process_file.hpp"
#include "model_kinds.hpp"
#include "repose/base/error.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using table::Table;
using State = ModelAccess::State;
using namespace model_names;

/// Version 1 has encoded coordinates of numbers on linear scales only, and counts instead of noise.
void read_points(const ModelReader& file, Dataset& data) {
  const Table points = file.read("/points");
  const auto n = static_cast<Eigen::Index>(points.rows());
  file.check(n > 0, "it has no points");
  const Eigen::Index d = data.encoding.dimension();
  data.natural.resize(n, d);
  data.x.resize(n, data.encoding.coordinates());
  for (Eigen::Index p = 0; p < data.x.cols(); ++p)
    data.x.col(p) = vector_of(points.numbers(encoded_column(p)));
  for (Eigen::Index k = 0; k < d; ++k) {
    const Input& input = data.encoding.inputs()[static_cast<std::size_t>(k)];
    if (file.version() == 1)
      data.natural.col(k) = input.lower + (input.upper - input.lower) * data.x.col(k).array();
    else
      data.natural.col(k) = vector_of(points.numbers(natural_column(k)));
  }
  data.y = vector_of(points.numbers("y"));
  data.noise = file.version() == 1 ? vector_of(points.numbers("count")).cwiseInverse().eval()
                                   : vector_of(points.numbers("noise"));
  file.check((data.noise.array() > 0.0).all() && data.noise.allFinite(),
             "a noise weight or count is not positive");
}

void read_rows(const ModelReader& file, Dataset& data) {
  const Table rows = file.read("/rows");
  Vector precision = Vector::Zero(data.points());
  data.value_of_row = rows.numbers("y");
  data.noise_of_row =
      file.version() == 1 ? std::vector<double>(rows.rows(), 1.0) : rows.numbers("noise");
  for (const std::int64_t point : rows.integers("point")) {
    file.check(point >= 0 && point < data.points(), "/rows names a point that is not there");
    data.point_of_row.push_back(static_cast<Eigen::Index>(point));
    const double w = data.noise_of_row[data.point_of_row.size() - 1];
    file.check(w > 0.0, "the noise of a row is not positive");
    precision[point] += 1.0 / w;
  }
  const Vector agreement = precision.cwiseProduct(data.noise);
  file.check((agreement.array() - 1.0).abs().maxCoeff() < 1e-6, "/rows and /points disagree");
}

Dataset read_dataset(const ModelReader& file, std::vector<Input> inputs, BasisFunctions functions) {
  Dataset data;
  const Kernel kernel = kernel_named(file.get<std::string>("kernel"));
  data.encoding = Encoding(std::move(inputs), kernel.length_scales);
  data.trend = {file.choice(file.get<std::string>("basis"), kBases), std::move(functions)};
  data.shift = file.get<double>("shift");
  data.scale = file.get<double>("scale");
  data.within = file.positive_or_zero("within");
  file.check(data.scale > 0.0, "the scale is not positive");
  read_points(file, data);
  read_rows(file, data);
  if (file.version() == 1) {
    data.log_repeats = -data.noise.array().log().sum();
  } else {
    data.response_scale = file.choice(file.get<std::string>("response_scale"), kScales);
    data.log_repeats = file.get<double>("log_repeats");
    data.log_jacobian = file.get<double>("log_jacobian");
  }
  data.h = trend_matrix(data.trend, data.encoding, data.natural, data.x);
  return data;
}

Covariance read_covariance(const ModelReader& file, const Dataset& data) {
  const bool old = file.version() == 1;
  Covariance c{.correlation = kernel_named(file.get<std::string>("kernel")).correlation,
               .length_scales =
                   vector_of(file.read(old ? "/inputs" : "/length_scales").numbers("length_scale")),
               .noise_ratio = file.positive_or_zero("noise_ratio"),
               .alpha = old ? 1.0 : file.positive_or_zero("alpha")};
  file.check(
      c.length_scales.size() == data.encoding.scales() && (c.length_scales.array() > 0.0).all(),
      "length scales are missing or not positive");
  file.check(c.alpha > 0.0, "alpha is not positive");
  return c;
}

Matrix read_factor(const ModelReader& file, Eigen::Index n) {
  const std::vector<double> packed = file.read("/factor").numbers("l");
  file.check(static_cast<Eigen::Index>(packed.size()) == n * (n + 1) / 2,
             "/factor has the wrong length");
  Matrix l = Matrix::Zero(n, n);
  std::size_t next = 0;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = j; i < n; ++i) l(i, j) = packed[next++];
  file.check((l.diagonal().array() > 0.0).all(), "/factor is not a Cholesky factor");
  return l;
}

FitReport read_report(const ModelReader& file) {
  FitReport report;
  report.termination = file.choice(file.get<std::string>("fit_termination"), kTerminations);
  report.message = file.get<std::string>("fit_message");
  report.evaluations = static_cast<int>(file.get<std::int64_t>("fit_evaluations"));
  if (file.has("fit_instruction_set"))  // not in early files of version 2
    report.instruction_set = file.get<std::string>("fit_instruction_set");
  report.seconds = file.get<double>("fit_seconds");
  report.jitter = file.get<double>("jitter");
  if (!file.has_table("/parameters")) return report;
  const Table t = file.read("/parameters");
  const std::vector<double> value = t.numbers("value");
  const std::vector<double> lower = t.numbers("lower");
  const std::vector<double> upper = t.numbers("upper");
  const std::vector<double> relevance = t.numbers("relevance");
  for (std::size_t i = 0; i < t.rows(); ++i)
    report.parameters.push_back({.name = t.texts("name")[i],
                                 .value = value[i],
                                 .lower = lower[i],
                                 .upper = upper[i],
                                 .state = file.choice(t.texts("state")[i], kStates),
                                 .relevance = relevance[i]});
  return report;
}

/// Parameters are taken as known by models of earlier versions.
ParameterPosterior read_parameter_posterior(const ModelReader& file, const State& s) {
  ParameterPosterior posterior;
  if (file.version() < 3) return posterior;
  posterior.variance_factor = file.get<double>("variance_factor");
  file.check(posterior.variance_factor >= 1.0 && std::isfinite(posterior.variance_factor),
             "the variance factor is below 1 or not finite");
  const auto directions = file.get<std::int64_t>("uncertain_directions");
  if (directions == 0) return posterior;
  const Table t = file.read("/parameter_uncertainty");
  file.check(static_cast<std::int64_t>(t.columns().size()) == directions,
             "/parameter_uncertainty has not a column for each direction");
  file.check(static_cast<Eigen::Index>(t.rows()) == shape_parameters(s.data, s.covariance),
             "/parameter_uncertainty has not a row for each parameter");
  posterior.root.resize(static_cast<Eigen::Index>(t.rows()),
                        static_cast<Eigen::Index>(t.columns().size()));
  for (Eigen::Index k = 0; k < posterior.root.cols(); ++k)
    posterior.root.col(k) = vector_of(t.numbers(root_column(k)));
  return posterior;
}

}  // namespace

void check_functions(const ModelReader& file, const BasisFunctions& functions) {
  std::vector<std::string> wanted;
  if (file.has_table("/functions")) wanted = file.read("/functions").texts("name");
  if (wanted != functions.names || (!wanted.empty() && !functions.evaluate))
    throw InputError(
        fmt::format("the model needs the regression functions [{}] it was fitted with, in this "
                    "order; [{}] were given",
                    fmt::join(wanted, ", "), fmt::join(functions.names, ", ")));
}

GaussianProcess read_process(const ModelReader& file, std::vector<Input> inputs,
                             BasisFunctions functions) {
  State s;
  s.data = read_dataset(file, std::move(inputs), std::move(functions));
  s.covariance = read_covariance(file, s.data);
  s.amplitude = file.positive_or_zero("amplitude");
  s.noise = file.choice(file.get<std::string>("noise"), kNoises);
  s.estimator = file.choice(file.get<std::string>("estimator"), kEstimators);
  s.factor =
      complete(s.data, {read_factor(file, s.data.points()), file.positive_or_zero("jitter")});
  s.parameters = read_parameter_posterior(file, s);
  s.find_sensitivity();
  s.report = read_report(file);
  return ModelAccess::make(std::move(s));
}

Regressor read_gaussian_process(const ModelReader& file, std::vector<Input> inputs) {
  return GaussianProcessRegressor(read_process(file, std::move(inputs), {}));
}

}  // namespace repose::surrogate
