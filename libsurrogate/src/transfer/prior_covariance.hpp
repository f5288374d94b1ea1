// What a Gaussian process was taken to be before it saw data.
#pragma once

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// m x p correlations between the rows of a and of b, each length scale times its factor.
Matrix prior_correlation(const GaussianProcess& model, const Matrix& a, const Matrix& b,
                         const Vector& length_factors);

/// n x n, of a target's function at the rows of x before any of them is known, averaged over the
/// relations to the source that CoregionalisedProcess deems possible.
Matrix prior_target_covariance(const GaussianProcess& source, const Matrix& x);

}  // namespace repose::surrogate
