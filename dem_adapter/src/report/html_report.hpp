// The report of a calibration as one self-contained HTML page.
#pragma once

#include <string>

#include "repose/dem_adapter/calibration.hpp"

namespace repose::dem_adapter {

std::string html_report(const Study& study, const Calibration& result);

}  // namespace repose::dem_adapter
