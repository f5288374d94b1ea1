// One run of an NLopt method.
#pragma once

#include "lbfgs.hpp"
#include "recorder.hpp"

namespace repose::opt {

/// One of NLopt's methods from x, a point of the box; what it found is in the recorder. Values that
/// are not finite are replaced by one worse than all seen. Rethrows exceptions of the objective.
RunEnd run_nlopt(Algorithm algorithm, const Vector& x, const MinimizerOptions& options,
                 Recorder& recorder);

/// The point nearest to x, in units of the box, that obeys the inequalities: a projection, by
/// SLSQP. If none is found, one that breaks them little.
Vector nearest_feasible(const Vector& x, const ReducedSet& space);

}  // namespace repose::opt
