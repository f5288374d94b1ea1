// A quasi-Newton method of limited memory inside a box.
#pragma once

#include "repose/opt/minimizer.hpp"

namespace repose::opt {

/// How one method ended; what it found is the objective's business to remember.
enum class RunEnd { converged, budget, gave_up };

/// Goes down from `start`, a point of the box, with at most max_evaluations of the objective, which
/// must fill in the gradient. Of the options it takes the tolerances and initial_curvature.
/// Gives up where the start has no finite value, and where the value stops falling though the slope
/// promises more than the tolerance.
RunEnd run_lbfgs(const Objective& objective, const Vector& start, const Bounds& bounds,
                 const MinimizerOptions& options, int max_evaluations);

}  // namespace repose::opt
