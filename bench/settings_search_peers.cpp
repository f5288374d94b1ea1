// Our side of bench/settings_search_peers.py: searches settings and says which it tried, what they
// predicted and how long it took.
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/settings_search.hpp"
#include "repose/table/io.hpp"

namespace {

using namespace repose;

/// All columns but the last are inputs.
surrogate::TrainingSet read(const std::string& file) {
  const auto table = table::read_table(table::parse_location(file));
  auto names = table.names();
  const std::string response = names.back();
  names.pop_back();
  surrogate::TrainingSet data{.x = table.matrix(names), .y = {}, .inputs = {}};
  const auto y = table.numbers(response);
  data.y = Eigen::Map<const Vector>(y.data(), static_cast<Eigen::Index>(y.size()));
  for (const auto& column : data.x.colwise())
    data.inputs.push_back({.lower = column.minCoeff(), .upper = column.maxCoeff()});
  return data;
}

nlohmann::json searched(const surrogate::TrainingSet& data, const surrogate::ModelFamily& family,
                        const surrogate::SettingsSearchOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const auto search = surrogate::search_settings(data, family, options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  nlohmann::json trials = nlohmann::json::array();
  for (const auto& trial : search.trials) {
    nlohmann::json settings;
    for (std::size_t k = 0; k < search.space.dimension(); ++k) {
      const Parameter& p = search.space.parameters()[k];
      const double value = trial.settings[static_cast<Eigen::Index>(k)];
      if (p.kind == ParameterKind::categorical)
        settings[p.name] = p.categories[static_cast<std::size_t>(value)];
      else
        settings[p.name] = value;
    }
    trials.push_back({{"settings", settings}, {"rmse", trial.rmse}, {"failure", trial.failure}});
  }
  return {{"seconds", seconds}, {"trials", trials}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s TABLE.csv EVALUATIONS\n", argv[0]);
    return 2;
  }
  const auto data = read(argv[1]);
  const surrogate::SettingsSearchOptions options{.evaluations = std::stoi(argv[2]), .folds = 5};
  std::vector<int> fold_of_row(static_cast<std::size_t>(data.rows()));
  const auto folds = surrogate::k_folds(data, {.folds = options.folds, .seed = options.seed});
  for (std::size_t f = 0; f < folds.size(); ++f)
    for (const auto row : folds[f].test)
      fold_of_row[static_cast<std::size_t>(row)] = static_cast<int>(f);
  const nlohmann::json result{
      {"folds", fold_of_row},
      {"ensemble", searched(data, surrogate::ensemble_family(), options)},
      {"gpr", searched(data, surrogate::gaussian_process_family(), options)}};
  std::printf("%s\n", result.dump(1).c_str());
}
