// Connected patches of labelled pixels.
#pragma once

#include <cstdint>
#include <vector>

namespace repose::dem_adapter {

/// Makes background (-1) of every patch of pixels with a label (connected by sides, whatever the
/// label) whose area is less than `fraction` of the largest patch's. Time and memory O(pixels).
void remove_specks(std::vector<std::int16_t>& label, int width, int height, double fraction);

}  // namespace repose::dem_adapter
