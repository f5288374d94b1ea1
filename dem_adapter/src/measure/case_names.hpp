// Names that users give, looked up in a case.
#pragma once

#include <string>

#include "repose/scene/case.hpp"

namespace repose::dem_adapter {

/// Throws InputError that lists the regions of the case unless it has this one.
void check_region(const scene::Case& scene, const std::string& name);

}  // namespace repose::dem_adapter
