#include "neighbor/skin.hpp"

#include <algorithm>
#include <cmath>

namespace repose::dem {

void Skin::adapt(double moved, std::int64_t steps) {
  if (fixed_ || steps <= 0) return;
  const double pace = moved / static_cast<double>(steps);
  const double product = std::sqrt(2.0 * kRebuildCost * pace * diameter_);
  const double best = 0.5 * diameter_ * (std::sqrt(1.0 + 4.0 * product / diameter_) - 1.0);
  width_ = std::clamp(best, 0.5 * kNarrowest * diameter_, 0.5 * kWidest * diameter_);
}

}  // namespace repose::dem
