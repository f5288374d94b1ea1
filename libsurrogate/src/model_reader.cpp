#include "repose/surrogate/model_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "model_names.hpp"
#include "repose/base/error.hpp"
#include "repose/table/io.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using table::Attributes;
using table::Table;
using State = ModelAccess::State;
using namespace model_names;

Vector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// A model file whose every inconsistency is a StorageError that names the file.
class Reader {
 public:
  explicit Reader(std::filesystem::path path)
      : path_(std::move(path)), attributes_(table::read_attributes({path_, "/"})) {}

  [[noreturn]] void damaged(const std::string& what) const {
    throw StorageError(
        fmt::format("model file '{}': {}; fit the model again", path_.string(), what));
  }
  void check(bool holds, const char* what) const {
    if (!holds) damaged(what);
  }

  template <class T>
  T get(const std::string& name) const {
    const auto found = attributes_.find(name);
    if (found == attributes_.end()) damaged(fmt::format("attribute '{}' is missing", name));
    const T* value = std::get_if<T>(&found->second);
    if (value == nullptr) damaged(fmt::format("attribute '{}' has the wrong type", name));
    return *value;
  }
  bool has(const std::string& name) const { return attributes_.contains(name); }
  double positive_or_zero(const std::string& name) const {
    const double value = get<double>(name);
    if (!std::isfinite(value) || value < 0.0)
      damaged(fmt::format("attribute '{}' is {}, which must not be negative", name, value));
    return value;
  }
  template <class Enum, std::size_t N>
  Enum choice(const std::string& text, const std::array<Enum, N>& values) const {
    for (const Enum value : values)
      if (text == to_string(value)) return value;
    damaged(fmt::format("'{}' is not known to this version", text));
  }
  std::int64_t version() const { return get<std::int64_t>("model_version"); }
  bool has_table(const std::string& group) const {
    for (const std::string& name : table::list_tables(path_))
      if (name == group) return true;
    return false;
  }
  Table read(const std::string& group) const { return table::read_table({path_, group}); }

 private:
  std::filesystem::path path_;
  Attributes attributes_;
};

std::vector<Input> read_inputs(const Reader& file, const Table& t) {
  const std::vector<double> lower = t.numbers("lower");
  const std::vector<double> upper = t.numbers("upper");
  file.check(t.rows() > 0, "it has no inputs");
  std::vector<Input> inputs;
  for (std::size_t k = 0; k < t.rows(); ++k)
    inputs.push_back({.lower = lower[k], .upper = upper[k]});
  if (file.version() == 1) return inputs;
  const std::vector<std::int64_t> levels = t.integers("levels");
  std::vector<std::string> level;
  if (file.has_table("/levels")) level = file.read("/levels").texts("level");
  std::size_t next = 0;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    inputs[k].scale = t.texts("scale")[k] == "log" ? Scale::log : Scale::linear;
    inputs[k].coding = file.choice(t.texts("coding")[k], kCodings);
    for (std::int64_t l = 0; l < levels[k]; ++l) {
      file.check(next < level.size(), "/levels is too short");
      inputs[k].levels.push_back(level[next++]);
    }
  }
  return inputs;
}

/// Version 1 has encoded coordinates of numbers on linear scales only, and counts instead of noise.
void read_points(const Reader& file, Dataset& data) {
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

void read_rows(const Reader& file, Dataset& data) {
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

Dataset read_dataset(const Reader& file, const Table& inputs, BasisFunctions functions) {
  Dataset data;
  const Kernel kernel = kernel_named(file.get<std::string>("kernel"));
  data.encoding = Encoding(read_inputs(file, inputs), kernel.length_scales);
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

Covariance read_covariance(const Reader& file, const Table& inputs, const Dataset& data) {
  const bool old = file.version() == 1;
  Covariance c{.correlation = kernel_named(file.get<std::string>("kernel")).correlation,
               .length_scales =
                   vector_of((old ? inputs : file.read("/length_scales")).numbers("length_scale")),
               .noise_ratio = file.positive_or_zero("noise_ratio"),
               .alpha = old ? 1.0 : file.positive_or_zero("alpha")};
  file.check(
      c.length_scales.size() == data.encoding.scales() && (c.length_scales.array() > 0.0).all(),
      "length scales are missing or not positive");
  file.check(c.alpha > 0.0, "alpha is not positive");
  return c;
}

/// Those the model was fitted with must be given again: a file holds no code.
void check_functions(const Reader& file, const BasisFunctions& functions) {
  std::vector<std::string> wanted;
  if (file.has_table("/functions")) wanted = file.read("/functions").texts("name");
  if (wanted != functions.names || (!wanted.empty() && !functions.evaluate))
    throw InputError(
        fmt::format("the model needs the regression functions [{}] it was fitted with, in this "
                    "order; [{}] were given",
                    fmt::join(wanted, ", "), fmt::join(functions.names, ", ")));
}

Matrix read_factor(const Reader& file, Eigen::Index n) {
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

FitReport read_report(const Reader& file) {
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
ParameterPosterior read_parameter_posterior(const Reader& file, const State& s) {
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

NamedModel read_model(const Reader& file, BasisFunctions functions) {
  const Table inputs = file.read("/inputs");
  State s;
  s.data = read_dataset(file, inputs, std::move(functions));
  s.covariance = read_covariance(file, inputs, s.data);
  s.amplitude = file.positive_or_zero("amplitude");
  s.noise = file.choice(file.get<std::string>("noise"), kNoises);
  s.estimator = file.choice(file.get<std::string>("estimator"), kEstimators);
  s.factor =
      complete(s.data, {read_factor(file, s.data.points()), file.positive_or_zero("jitter")});
  s.parameters = read_parameter_posterior(file, s);
  s.find_sensitivity();
  s.report = read_report(file);
  return {ModelAccess::make(std::move(s)), inputs.texts("name"), file.get<std::string>("response")};
}

void check_version(const Reader& file) {
  if (!file.has("repose_model") || file.get<std::string>("repose_model") != kModel)
    file.damaged("it holds no Gaussian process");
  if (file.version() < 1 || file.version() > kVersion)
    file.damaged(
        fmt::format("its version is {}, this program reads 1 to {}", file.version(), kVersion));
}

}  // namespace

NamedModel load_model(const std::filesystem::path& path, const BasisFunctions& functions) {
  const Reader file(path);
  check_version(file);
  check_functions(file, functions);
  try {
    return read_model(file, functions);
  } catch (const InputError& error) {  // a column that is missing, of the wrong type or not finite
    file.damaged(error.what());
  }
}

}  // namespace repose::surrogate
