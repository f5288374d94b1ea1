// max(0, u) with a tail that never vanishes, see log_composite_expected_improvement.
#pragma once

namespace repose::opt {

double soft_improvement(double u, double best);
double soft_improvement_slope(double u, double best);

}  // namespace repose::opt
