#include "validation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>

namespace repose::cli {
namespace {

/// Steps of a search count one each, and so does a fold of any model.
class StepCounter {
 public:
  StepCounter(double total, ProgressStyle style) : total_(total), display_("steps", style) {}
  void step(std::string_view note) {
    const std::lock_guard lock(mutex_);
    display_.update(++done_, total_, note);
  }

 private:
  std::mutex mutex_;
  double done_ = 0.0;
  double total_;
  ProgressDisplay display_;
};

}  // namespace

surrogate::Trainer trainer_of(const std::string& model, const TrainingTable& table,
                              const surrogate::SettingsSearchOptions& search) {
  return surrogate::with_ranges_of_training_rows(surrogate::preset_trainer(model, search),
                                                 table.undeclared);
}

std::vector<surrogate::CrossValidation> validate(const TrainingTable& table,
                                                 const std::vector<surrogate::Fold>& folds,
                                                 const ValidationOptions& options,
                                                 ProgressStyle style) {
  double total = 0.0;
  for (const auto& model : options.models)
    total += static_cast<double>(folds.size()) *
             (1.0 + (surrogate::model_preset(model).searched ? options.search.evaluations : 0));
  StepCounter counter(total, style);
  std::vector<surrogate::Trainer> trainers;
  for (const auto& model : options.models) {
    surrogate::SettingsSearchOptions search = options.search;
    search.progress = [&counter, model](double, double, std::string_view) { counter.step(model); };
    trainers.push_back(trainer_of(model, table, search));
  }
  return surrogate::cross_validate(
      table.data, trainers, folds,
      {.seed = options.seed,
       .threads = options.threads,
       .progress = [&counter](double, double, std::string_view note) { counter.step(note); }});
}

std::string cell(double value, const char* format) {
  if (std::isnan(value)) return "-";
  return fmt::format(fmt::runtime(format), value);
}

std::string described(const std::string& name, const std::string& description) {
  constexpr std::size_t kColumns = 100;
  std::string text, line = "  " + name + ":";
  std::istringstream words(description);
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > kColumns) {
      text += line + "\n";
      line = "     ";
    }
    line += " " + word;
  }
  return text + line + "\n";
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json to_json(const surrogate::Metrics& m) {
  return {{"rows", m.rows},
          {"rmse", number_or_null(m.rmse)},
          {"r2", number_or_null(m.r2)},
          {"squared_correlation", number_or_null(m.squared_correlation)},
          {"mae", number_or_null(m.mae)},
          {"negative_log_density", number_or_null(m.negative_log_density)}};
}

nlohmann::json to_json(const surrogate::FoldResult& fold) {
  nlohmann::json json = to_json(fold.metrics);
  json["name"] = fold.name;
  json["repetition"] = fold.repetition;
  json["model"] = fold.description;
  json["failure"] = fold.failure;
  json["note"] = fold.note;
  json["training_seconds"] = fold.training_seconds;
  json["prediction_seconds"] = fold.prediction_seconds;
  return json;
}

}  // namespace repose::cli
