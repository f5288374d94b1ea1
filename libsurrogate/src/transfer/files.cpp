// Transferred models in files.
#include <cmath>
#include <limits>

#include "gaussian_process_file.hpp"
#include "model_kinds.hpp"
#include "parts.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/coregionalised_process.hpp"

namespace repose::surrogate {
namespace {

using table::Table;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string part_name(std::size_t i) {
  return "part" + std::to_string(i + 1);
}
std::string factor_column(Eigen::Index k) {
  return "length_factor" + std::to_string(k + 1);
}

/// Another model's content below a name of its own.
void add_nested(ModelContent& content, const std::string& name, const Regressor& model) {
  ModelContent nested = content_of(model);
  for (auto& [key, value] : nested.attributes)
    content.attributes[name + "." + key] = std::move(value);
  for (auto& [group, table] : nested.tables) content.add("/" + name + group, std::move(table));
}

/// What differs from the source; a part that is another model is nested.
void add_part(ModelContent& content, const std::string& name, const Regressor& model) {
  if (const auto* shifted = model.target<ShiftedModel>()) {
    auto& a = content.attributes;
    a[name + ".shift"] = shifted->shift;
    a[name + ".scale"] = shifted->scale;
    a[name + ".noise_variance"] = shifted->noise_variance;
    if (std::isnan(shifted->residual_variance)) return;
    a[name + ".residual_variance"] = shifted->residual_variance;
    Table t;
    add_column(t, "covariance", doubles(shifted->covariance.reshaped()));
    content.add("/" + name + "/coefficients", std::move(t));
  } else if (const auto* basis = model.target<SourceBasisProcess>()) {
    add_nested(content, name, GaussianProcessRegressor(basis->target));
  } else if (const auto* process = model.target<CoregionalisedProcess>()) {
    Table points, relations;
    for (Eigen::Index k = 0; k < process->points().cols(); ++k)
      add_column(points, "x" + std::to_string(k + 1), doubles(process->points().col(k)));
    add_column(points, "y", doubles(process->values()));
    content.add("/" + name + "/points", std::move(points));
    const auto add = [&](const std::string& column, const auto& value) {
      std::vector<double> values;
      for (const TaskRelation& r : process->relations()) values.push_back(value(r));
      add_column(relations, column, values);
    };
    add("correlation", [](const TaskRelation& r) { return r.correlation; });
    add("scale", [](const TaskRelation& r) { return r.scale; });
    add("own_variance", [](const TaskRelation& r) { return r.own_variance; });
    add("shift_deviation", [](const TaskRelation& r) { return r.shift_deviation; });
    add("noise_variance", [](const TaskRelation& r) { return r.noise_variance; });
    add("weight", [](const TaskRelation& r) { return r.weight; });
    for (Eigen::Index k = 0; k < process->relations().front().length_factors.size(); ++k)
      add(factor_column(k), [k](const TaskRelation& r) { return r.length_factors[k]; });
    content.add("/" + name + "/relations", std::move(relations));
  } else {
    add_nested(content, name, model);
  }
}

const GaussianProcess& source_process(const ModelReader& file, const Regressor& source) {
  const GaussianProcess* process = gaussian_process(source);
  file.check(process != nullptr, "the source is no Gaussian process, which a part needs");
  return *process;
}

std::vector<TaskRelation> read_relations(const ModelReader& file, Eigen::Index scales) {
  const Table t = file.read("/relations");
  std::vector<TaskRelation> relations(t.rows());
  const auto read = [&](const std::string& column, const auto& place) {
    const std::vector<double> values = t.numbers(column);
    for (std::size_t i = 0; i < values.size(); ++i) place(relations[i]) = values[i];
  };
  for (TaskRelation& r : relations) r.length_factors.resize(scales);
  read("correlation", [](TaskRelation& r) -> double& { return r.correlation; });
  read("scale", [](TaskRelation& r) -> double& { return r.scale; });
  read("own_variance", [](TaskRelation& r) -> double& { return r.own_variance; });
  read("shift_deviation", [](TaskRelation& r) -> double& { return r.shift_deviation; });
  read("noise_variance", [](TaskRelation& r) -> double& { return r.noise_variance; });
  read("weight", [](TaskRelation& r) -> double& { return r.weight; });
  for (Eigen::Index k = 0; k < scales; ++k)
    read(factor_column(k), [k](TaskRelation& r) -> double& { return r.length_factors[k]; });
  return relations;
}

Regressor read_coregionalised(const ModelReader& file, const GaussianProcess& source) {
  const Table t = file.read("/points");
  Matrix x(static_cast<Eigen::Index>(t.rows()), source.dimension());
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    x.col(k) = vector_of(t.numbers("x" + std::to_string(k + 1)));
  const auto relations = read_relations(file, source.hyperparameters().length_scales.size());
  try {
    return CoregionalisedProcess::with_relations(source, x, vector_of(t.numbers("y")), relations);
  } catch (const Error& error) {
    file.damaged(error.what());
  }
}

Regressor read_shifted(const ModelReader& file, const Regressor& source) {
  ShiftedModel model{.source = source,
                     .shift = file.get<double>("shift"),
                     .scale = file.get<double>("scale"),
                     .covariance = Matrix::Constant(2, 2, kNaN),
                     .residual_variance = kNaN,
                     .noise_variance = file.positive_or_zero("noise_variance")};
  if (!file.has("residual_variance")) return model;
  const std::vector<double> covariance = file.read("/coefficients").numbers("covariance");
  file.check(covariance.size() == 4, "a part's covariance has the wrong length");
  model.covariance = Eigen::Map<const Matrix>(covariance.data(), 2, 2);
  model.residual_variance = file.positive_or_zero("residual_variance");
  return model;
}

Regressor read_part(const ModelReader& file, TransferMethod method, const Regressor& source) {
  switch (method) {
    case TransferMethod::shift_and_scale:
      return read_shifted(file, source);
    case TransferMethod::coregionalised:
      return read_coregionalised(file, source_process(file, source));
    case TransferMethod::source_basis: {
      const GaussianProcess& process = source_process(file, source);
      return SourceBasisProcess{process,
                                read_process(file, source.inputs(), mean_function(process))};
    }
    case TransferMethod::retrained:
    case TransferMethod::target_only:
      return read_content(file, source.inputs());
    case TransferMethod::weighted:
      break;
  }
  file.damaged("a part is made of parts");
}

}  // namespace

std::optional<ModelContent> write_transferred(const Regressor& model) {
  const auto* transferred = model.target<TransferredModel>();
  if (transferred == nullptr) return std::nullopt;
  ModelContent content;
  if (std::isfinite(transferred->correlation))
    content.attributes["correlation"] = transferred->correlation;
  if (std::isfinite(transferred->correlation_deviation))
    content.attributes["correlation_deviation"] = transferred->correlation_deviation;
  std::vector<std::string> methods;
  std::vector<double> weights;
  add_nested(content, "source", transferred->source);
  for (std::size_t i = 0; i < transferred->parts.size(); ++i) {
    const auto& part = transferred->parts[i];
    methods.emplace_back(to_string(part.method));
    weights.push_back(part.weight);
    add_part(content, part_name(i), part.model);
  }
  Table parts;
  add_column(parts, "method", methods);
  add_column(parts, "weight", weights);
  content.add("/parts", std::move(parts));
  return content;
}

Regressor read_transferred(const ModelReader& file, std::vector<Input> inputs) {
  const auto known = [&file](const char* name) {
    return file.has(name) ? file.get<double>(name) : kNaN;
  };
  TransferredModel model{.source = read_content(file.below("source"), std::move(inputs)),
                         .correlation = known("correlation"),
                         .correlation_deviation = known("correlation_deviation")};
  const Table parts = file.read("/parts");
  const auto methods = parts.texts("method");
  const auto weights = parts.numbers("weight");
  file.check(!methods.empty(), "it has no parts");
  double sum = 0.0;
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const TransferMethod method = file.choice(methods[i], kTransferMethods);
    file.check(weights[i] >= 0.0 && weights[i] <= 1.0, "a weight is not in [0, 1]");
    sum += weights[i];
    model.parts.push_back(
        {method, weights[i], read_part(file.below(part_name(i)), method, model.source)});
  }
  file.check(std::abs(sum - 1.0) < 1e-9, "the weights of its parts do not sum to 1");
  return model;
}

}  // namespace repose::surrogate
