// Which kernel and which trend: all of them are fitted, and what is left out decides.
#pragma once

#include <string>
#include <vector>

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

struct SelectionOptions {
  std::vector<Kernel> kernels = all_kernels();
  std::vector<Basis> bases = {Basis::none, Basis::constant, Basis::linear, Basis::quadratic};
  /// A group for each row, left out together: a material, a laboratory. Empty: single points.
  std::vector<Eigen::Index> groups = {};
  unsigned threads = 1;  ///< over candidates; the result does not depend on it (0: one each core)
};

/// One candidate; figures of the rows left out, hyper-parameters kept from the fit to all.
struct Candidate {
  Kernel kernel;
  Basis basis = Basis::constant;
  double log_density = 0.0;  ///< LeftOut::log_density, what candidates are ranked by
  double q2 = 0.0;
  double rmse = 0.0;
  double coverage95 = 0.0;
  double negative_log_likelihood = 0.0;  ///< not comparable between bases where restricted
  double seconds = 0.0;
  std::string failure;  ///< why there is no model, or why it cannot predict what is left out
};

struct Selection {
  GaussianProcess model;
  std::vector<Candidate> candidates;  ///< best first; those that failed last
};

/// Fits every kernel with every basis, `options` otherwise, and keeps the one with the largest log
/// predictive density of what was left out, in closed form. A candidate that is not defined for
/// these data (too few points, dependent regression functions, a group that alone determines a
/// coefficient) is ranked last and says so. Throws the error of the first one if all fail.
Selection select_model(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                       const GaussianProcessOptions& options = {},
                       const SelectionOptions& selection = {});

}  // namespace repose::surrogate
