// What `repose compare` and `repose cv` share: models by name, cross-validated side by side.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/presets.hpp"
#include "training_data.hpp"

namespace repose::cli {

/// Of the command line.
struct ValidationOptions {
  std::vector<std::string> models;
  surrogate::SettingsSearchOptions search = {};  ///< of models that search their settings
  std::uint64_t seed = 1;
  unsigned threads = 0;
};

/// Cross-validates all models on the same folds, with progress over models, folds and searches.
std::vector<surrogate::CrossValidation> validate(const TrainingTable& table,
                                                 const std::vector<surrogate::Fold>& folds,
                                                 const ValidationOptions& options,
                                                 ProgressStyle style);

/// The trainer of a model by name, ranges that are not declared taken from the rows it is given.
surrogate::Trainer trainer_of(const std::string& model, const TrainingTable& table,
                              const surrogate::SettingsSearchOptions& search);

/// "0.0123", "-" where not defined.
std::string cell(double value, const char* format = "{:.4g}");

/// "NAME: description", lines of at most 100 columns.
std::string described(const std::string& name, const std::string& description);

/// Null where it is not finite.
nlohmann::json number_or_null(double value);
nlohmann::json to_json(const surrogate::Metrics& metrics);
nlohmann::json to_json(const surrogate::FoldResult& fold);

}  // namespace repose::cli
