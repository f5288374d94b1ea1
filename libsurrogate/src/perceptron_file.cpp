// Perceptrons in files.
#include "model_kinds.hpp"
#include "perceptron_state.hpp"
#include "standardised_file.hpp"

namespace repose::surrogate {
namespace {

std::string network_column(std::size_t i) {
  return fmt::format("network{}", i + 1);
}

}  // namespace

std::optional<ModelContent> write_perceptron(const Regressor& model) {
  const auto* perceptron = model.target<Perceptron>();
  if (perceptron == nullptr) return std::nullopt;
  const auto& s = PerceptronAccess::state(*perceptron);
  ModelContent content{
      .attributes = {{"shift", s.shift},
                     {"scale", s.scale},
                     {"networks", static_cast<std::int64_t>(s.parameters.size())}}};
  content.add("/columns", columns_table(s.columns));
  table::Table layers;
  add_column(layers, "neurons", std::vector<std::int64_t>(s.layers.begin(), s.layers.end()));
  content.add("/layers", std::move(layers));
  table::Table parameters;
  for (std::size_t i = 0; i < s.parameters.size(); ++i)
    add_column(parameters, network_column(i), doubles(s.parameters[i]));
  content.add("/parameters", std::move(parameters));
  std::vector<double> loss;
  std::vector<std::int64_t> evaluations, converged;
  for (const PerceptronTraining& training : s.training) {
    loss.push_back(training.loss);
    evaluations.push_back(training.evaluations);
    converged.push_back(training.converged ? 1 : 0);
  }
  table::Table training;
  add_column(training, "loss", loss);
  add_column(training, "evaluations", evaluations);
  add_column(training, "converged", converged);
  content.add("/training", std::move(training));
  return content;
}

Regressor read_perceptron(const ModelReader& file, std::vector<Input> inputs) {
  PerceptronAccess::State s{.columns = read_columns(file, std::move(inputs)),
                            .shift = file.get<double>("shift"),
                            .scale = file.positive_or_zero("scale")};
  for (const std::int64_t neurons : file.read("/layers").integers("neurons")) {
    file.check(neurons >= 1 && neurons <= 1000, "a layer has an impossible number of neurons");
    s.layers.push_back(static_cast<int>(neurons));
  }
  if (file.has_table("/parameters")) {
    const table::Table parameters = file.read("/parameters"), training = file.read("/training");
    const auto loss = training.numbers("loss");
    const auto evaluations = training.integers("evaluations"),
               converged = training.integers("converged");
    file.check(static_cast<Eigen::Index>(parameters.rows()) == s.network().parameters() &&
                   training.rows() == parameters.columns().size(),
               "/parameters does not fit to /layers or /training");
    for (std::size_t i = 0; i < training.rows(); ++i) {
      s.parameters.push_back(vector_of(parameters.numbers(network_column(i))));
      s.training.push_back({loss[i], static_cast<int>(evaluations[i]), converged[i] == 1});
    }
  }
  file.check(static_cast<std::int64_t>(s.parameters.size()) == file.get<std::int64_t>("networks"),
             "/parameters does not have as many columns as the attribute networks says");
  return PerceptronAccess::make(std::move(s));
}

}  // namespace repose::surrogate
