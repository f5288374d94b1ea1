// Which inputs a model uses: how much worse it predicts when one of them is exchanged among rows.
#pragma once

#include <cstdint>
#include <vector>

#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// Of an input: the increase of the mean square error, in squared units of y. About 0 or below for
/// an input that the model does not use; inputs that tell the same share theirs.
struct Importance {
  double increase = 0.0;
  double standard_error = 0.0;  ///< of the mean over permutations (or trees)
};

struct ImportanceOptions {
  Eigen::Index permutations = 20;  ///< >= 2
  std::uint64_t seed = 1;
};

/// Over the rows of `data`, by weight. Of rows the model was fitted to it tells what was learnt,
/// noise included; of others what is true [Breiman2001].
std::vector<Importance> permutation_importance(const Regressor& model, const TrainingSet& data,
                                               const ImportanceOptions& options = {});

}  // namespace repose::surrogate
