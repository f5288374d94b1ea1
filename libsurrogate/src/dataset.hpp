// Training data as the likelihood wants them: scaled inputs, standardised outputs, repeats
// aggregated.
#pragma once

#include <vector>

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// n different points in lexicographic order (appended ones last), so that a fit does not depend on
/// the order of the rows. Repeats enter the exact likelihood by count, mean and squares
/// [Binois2018].
struct Dataset {
  opt::Bounds declared;
  double shift = 0.0;  ///< y = shift + scale * standardised
  double scale = 1.0;
  Matrix x;             ///< n x d, (natural - lower)/(upper - lower)
  Vector y;             ///< mean at each point, standardised
  Vector count;         ///< observations at each point
  double within = 0.0;  ///< sum over observations of (y - mean at its point)^2, standardised
  /// Each observation in the user's order: its point, its standardised value.
  std::vector<Eigen::Index> point_of_row;
  std::vector<double> value_of_row;

  Eigen::Index points() const { return x.rows(); }
  Eigen::Index dimension() const { return x.cols(); }
  Eigen::Index observations() const { return static_cast<Eigen::Index>(value_of_row.size()); }
  Matrix to_unit(const Matrix& natural) const;
  /// Row of `unit` among the points, or -1.
  Eigen::Index find(const Vector& unit) const;
};

/// Throws InputError as GaussianProcess::fit says, all but the number of points.
Dataset make_dataset(const Matrix& x, const Vector& y, const opt::Bounds& declared, Basis basis,
                     Noise noise);

/// With one observation more at unit coordinates; the standardisation is kept.
Dataset with_observation(const Dataset& data, const Vector& unit, double standardised, Noise noise);

/// n x q regression functions at the rows of x.
Matrix basis_matrix(Basis basis, const Matrix& x);
Eigen::Index basis_size(Basis basis);

}  // namespace repose::surrogate
