// Our side of bench/settings_search_peers.py: searches settings and says which it tried, what they
// predicted and how long it took. Also writes the table that docs/validation/model_comparison.md
// is about.
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "grouped_screening.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/settings_search.hpp"

namespace {

using namespace repose;

/// 185 rows of 18 inputs, the group and the response.
void print_table() {
  const auto screening = surrogate::test::grouped_screening(1);
  const surrogate::TrainingSet& data = screening.data;
  for (const auto& name : screening.names) fmt::print("{},", name);
  fmt::print("configuration,segregation\n");
  for (Eigen::Index i = 0; i < data.rows(); ++i) {
    for (const double value : data.x.row(i)) fmt::print("{},", value);
    fmt::print("ic{},{}\n", data.groups[static_cast<std::size_t>(i)] + 1, data.y[i]);
  }
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

void print_searches(int evaluations) {
  const surrogate::TrainingSet data = surrogate::test::grouped_screening(1).data;
  const surrogate::SettingsSearchOptions options{.evaluations = evaluations, .folds = 5};
  std::vector<int> fold_of_row(static_cast<std::size_t>(data.rows()));
  const auto folds = surrogate::k_folds(data, {.folds = options.folds, .seed = options.seed});
  for (std::size_t f = 0; f < folds.size(); ++f)
    for (const auto row : folds[f].test)
      fold_of_row[static_cast<std::size_t>(row)] = static_cast<int>(f);
  const nlohmann::json result{
      {"folds", fold_of_row},
      {"ensemble", searched(data, surrogate::ensemble_family(), options)},
      {"gpr", searched(data, surrogate::gaussian_process_family(), options)}};
  fmt::print("{}\n", result.dump(1));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "table") {
    print_table();
  } else if (what == "search" && argc == 3) {
    print_searches(std::stoi(argv[2]));
  } else {
    fmt::print(stderr, "usage: {} table | search EVALUATIONS\n", argv[0]);
    return 2;
  }
}
