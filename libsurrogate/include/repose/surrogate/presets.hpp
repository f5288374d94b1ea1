// The regression models of the thesis' Table 4.2, by name.
#pragma once

#include <string>
#include <vector>

#include "repose/surrogate/settings_search.hpp"

namespace repose::surrogate {

/// A model with settings of its own, or with settings to be searched.
struct ModelPreset {
  std::string name;     ///< "fine-tree"
  std::string group;    ///< "Regression Tree", as [Hadi2026, Table 4.2] heads its rows
  std::string variant;  ///< "Fine"
  bool searched = false;
  bool gaussian_process = false;  ///< of the response itself
};

/// The rows of that table in its order, with the settings of MATLAB's presets, then ours: "gpr", a
/// Gaussian process as fitted by default.
const std::vector<ModelPreset>& model_presets();

/// Throws InputError with the closest name, or all.
const ModelPreset& model_preset(const std::string& name);

/// Throws as model_preset(). `search` is of presets with searched settings.
Trainer preset_trainer(const std::string& name, const SettingsSearchOptions& search = {});

/// A model of known configurations, and how it is fitted to more rows without a new search: with
/// the hyper-parameters of a Gaussian process that has some (of a constant response: found anew),
/// or the settings found or given of another model.
struct PretrainedModel {
  Regressor model;
  Trainer again;
};

/// Fits a preset to `data`. Throws as preset_trainer() and its fit.
PretrainedModel pretrained(const std::string& name, const TrainingSet& data, std::uint64_t seed,
                           const SettingsSearchOptions& search = {});

}  // namespace repose::surrogate
