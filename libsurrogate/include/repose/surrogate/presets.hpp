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
};

/// The rows of that table in its order, with the settings of MATLAB's presets, then ours: "gpr", a
/// Gaussian process as fitted by default.
const std::vector<ModelPreset>& model_presets();

/// Throws InputError with the closest name, or all. `search` is of presets with searched settings.
Trainer preset_trainer(const std::string& name, const SettingsSearchOptions& search = {});

}  // namespace repose::surrogate
