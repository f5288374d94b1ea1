// The files data/scenarios/*.toml, put into the library when it is built.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace repose::dem_adapter {

/// Name and text of each, by name.
const std::vector<std::pair<std::string, std::string>>& shipped_texts();

}  // namespace repose::dem_adapter
