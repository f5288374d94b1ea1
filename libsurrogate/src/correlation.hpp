// Correlation matrices of points.
#pragma once

#include "dense.hpp"
#include "repose/base/parameter_space.hpp"

namespace repose::surrogate {

/// A correlation function with its parameters; weight[k] = 1/l^2 of coordinate k.
struct Correlator {
  Correlation correlation = Correlation::matern52;
  double alpha = 1.0;
  Vector weight;
};

/// n x m correlations between the rows of x (n x d) and of q (m x d).
Matrix cross_correlation(const Correlator& correlator, const Matrix& x, const Matrix& q);

/// The same with its slopes (see Slopes), n x m each; alpha's for the rational quadratic only.
struct CrossCorrelation {
  Matrix r;
  Matrix slope;
  Matrix alpha_slope;

  CrossCorrelation(const Correlator& correlator, const Matrix& x, const Matrix& q);
};

/// Derivatives of the slopes in r^2, to one point q; 0 at distance 0, where they are multiplied by
/// it.
struct SecondSlopes {
  Vector scale;
  Vector alpha;

  SecondSlopes(const Correlator& correlator, const Matrix& x, const Matrix& q,
               const CrossCorrelation& k);
};

/// Lower triangle with unit diagonal; the rest is left alone. Of the slopes, n x n, only what lies
/// below the diagonal is filled; empty matrices are not wanted.
void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower, Matrix& slope,
                      Matrix& alpha_slope);
void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower);

}  // namespace repose::surrogate
