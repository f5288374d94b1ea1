#include "repose/surrogate/model_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/table/io.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using table::Attributes;
using table::Column;
using table::Table;
using State = ModelAccess::State;

constexpr const char* kModel = "gaussian-process";
constexpr std::int64_t kVersion = 1;
constexpr std::array kNoises{"none", "estimated"};
constexpr std::array kBases{"none", "constant"};
constexpr std::array kEstimators{"ml", "reml"};
constexpr std::array kTerminations{"converged", "budget", "round_off", "failed"};
constexpr std::array kStates{"converged", "at_lower_bound", "at_upper_bound", "inert"};

template <class Vectorlike>
std::vector<double> doubles(const Vectorlike& values) {
  std::vector<double> v(static_cast<std::size_t>(values.size()));
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = values[static_cast<Eigen::Index>(i)];
  return v;
}

Vector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void add(Table& table, std::string name, table::Values values) {
  table.add({.name = std::move(name), .values = std::move(values)});
}

std::string coordinate(Eigen::Index k) {
  return fmt::format("u{}", k + 1);
}

// ---- writing
// -------------------------------------------------------------------------------------

Attributes file_attributes(const State& s, const std::string& response) {
  const auto name = [](const auto& names, auto value) {
    return std::string(names[static_cast<std::size_t>(value)]);
  };
  return {{"repose_model", std::string(kModel)},
          {"model_version", kVersion},
          {"response", response},
          {"kernel", std::string(to_string(s.covariance.kernel))},
          {"noise", name(kNoises, s.noise)},
          {"basis", name(kBases, s.basis)},
          {"estimator", name(kEstimators, s.estimator)},
          {"shift", s.data.shift},
          {"scale", s.data.scale},
          {"within", s.data.within},
          {"amplitude", s.amplitude},
          {"noise_ratio", s.covariance.noise_ratio},
          {"jitter", s.factor.jitter},
          {"fit_termination", name(kTerminations, s.report.termination)},
          {"fit_message", s.report.message},
          {"fit_evaluations", static_cast<std::int64_t>(s.report.evaluations)},
          {"fit_seconds", s.report.seconds}};
}

Table inputs_table(const State& s, const std::vector<std::string>& names) {
  Table t;
  add(t, "name", names);
  add(t, "lower", doubles(s.data.declared.lower));
  add(t, "upper", doubles(s.data.declared.upper));
  add(t, "length_scale", doubles(s.covariance.length_scales));
  return t;
}

Table points_table(const Dataset& data) {
  Table t;
  for (Eigen::Index k = 0; k < data.dimension(); ++k) add(t, coordinate(k), doubles(data.x.col(k)));
  add(t, "y", doubles(data.y));
  add(t, "count", doubles(data.count));
  return t;
}

Table rows_table(const Dataset& data) {
  Table t;
  add(t, "point", std::vector<std::int64_t>(data.point_of_row.begin(), data.point_of_row.end()));
  add(t, "y", data.value_of_row);
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

// ---- reading
// -------------------------------------------------------------------------------------

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
  Enum choice(const std::string& text, const std::array<const char*, N>& names) const {
    for (std::size_t i = 0; i < N; ++i)
      if (text == names[i]) return static_cast<Enum>(i);
    damaged(fmt::format("'{}' is not known to this version", text));
  }
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

Dataset read_dataset(const Reader& file, const Table& inputs) {
  Dataset data;
  data.declared = {vector_of(inputs.numbers("lower")), vector_of(inputs.numbers("upper"))};
  data.shift = file.get<double>("shift");
  data.scale = file.get<double>("scale");
  data.within = file.positive_or_zero("within");
  const Table points = file.read("/points");
  data.x.resize(static_cast<Eigen::Index>(points.rows()), static_cast<Eigen::Index>(inputs.rows()));
  for (Eigen::Index k = 0; k < data.x.cols(); ++k)
    data.x.col(k) = vector_of(points.numbers(coordinate(k)));
  data.y = vector_of(points.numbers("y"));
  data.count = vector_of(points.numbers("count"));
  const Table rows = file.read("/rows");
  for (const std::int64_t point : rows.integers("point")) {
    file.check(point >= 0 && point < data.points(), "/rows names a point that is not there");
    data.point_of_row.push_back(static_cast<Eigen::Index>(point));
  }
  data.value_of_row = rows.numbers("y");
  file.check(data.dimension() > 0 && data.points() > 0, "it has no inputs or no points");
  file.check((data.declared.lower.array() < data.declared.upper.array()).all(),
             "a declared range is empty");
  file.check((data.count.array() >= 1.0).all() && data.scale > 0.0,
             "a count or the scale is not positive");
  file.check(static_cast<double>(data.observations()) == data.count.sum(),
             "/rows and /points disagree");
  return data;
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
  report.termination =
      file.choice<opt::Termination>(file.get<std::string>("fit_termination"), kTerminations);
  report.message = file.get<std::string>("fit_message");
  report.evaluations = static_cast<int>(file.get<std::int64_t>("fit_evaluations"));
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
                                 .state = file.choice<ParameterState>(t.texts("state")[i], kStates),
                                 .relevance = relevance[i]});
  return report;
}

NamedModel read_model(const Reader& file) {
  if (!file.has("repose_model") || file.get<std::string>("repose_model") != kModel)
    file.damaged("it holds no Gaussian process");
  const auto version = file.get<std::int64_t>("model_version");
  if (version != kVersion)
    file.damaged(fmt::format("its version is {}, this program reads {}", version, kVersion));
  const Table inputs = file.read("/inputs");
  State s;
  s.data = read_dataset(file, inputs);
  s.covariance = {kernel_named(file.get<std::string>("kernel")),
                  vector_of(inputs.numbers("length_scale")), file.positive_or_zero("noise_ratio")};
  file.check((s.covariance.length_scales.array() > 0.0).all(), "a length scale is not positive");
  s.amplitude = file.positive_or_zero("amplitude");
  s.noise = file.choice<Noise>(file.get<std::string>("noise"), kNoises);
  s.basis = file.choice<Basis>(file.get<std::string>("basis"), kBases);
  s.estimator = file.choice<Estimator>(file.get<std::string>("estimator"), kEstimators);
  s.factor = complete(s.data, s.basis,
                      {read_factor(file, s.data.points()), file.positive_or_zero("jitter")});
  s.report = read_report(file);
  return {ModelAccess::make(std::move(s)), inputs.texts("name"), file.get<std::string>("response")};
}

}  // namespace

void save_model(const std::filesystem::path& path, const NamedModel& model) {
  const State& s = ModelAccess::state(model.model);
  if (static_cast<Eigen::Index>(model.inputs.size()) != model.model.dimension())
    throw InputError(fmt::format("{} input names for a model of {} inputs", model.inputs.size(),
                                 model.model.dimension()));
  std::vector<std::pair<std::string, Table>> tables{{"/inputs", inputs_table(s, model.inputs)},
                                                    {"/points", points_table(s.data)},
                                                    {"/rows", rows_table(s.data)},
                                                    {"/factor", factor_table(s.factor.l)}};
  if (!s.report.parameters.empty())
    tables.emplace_back("/parameters", parameters_table(s.report.parameters));
  table::write_tables(path, tables, file_attributes(s, model.response));
}

NamedModel load_model(const std::filesystem::path& path) {
  const Reader file(path);
  try {
    return read_model(file);
  } catch (const InputError& error) {  // a column that is missing, of the wrong type or not finite
    file.damaged(error.what());
  }
}

}  // namespace repose::surrogate
