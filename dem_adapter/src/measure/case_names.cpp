#include "case_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {

void check_region(const scene::Case& scene, const std::string& name) {
  std::vector<std::string> known;
  for (const auto& region : scene.regions) known.push_back(region.name);
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw InputError(fmt::format("the run has no region '{}'; it has {}", name,
                                 known.empty() ? "none" : listed(known)));
}

}  // namespace repose::dem_adapter
