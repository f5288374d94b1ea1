// What a Gaussian process was taken to be before it saw data.
#pragma once

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// m x p correlations between the rows of a and of b, each length scale times its factor.
Matrix prior_correlation(const GaussianProcess& model, const Matrix& a, const Matrix& b,
                         const Vector& length_factors);

}  // namespace repose::surrogate
