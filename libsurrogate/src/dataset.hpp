// Training data as the likelihood wants them: encoded inputs, standardised outputs, repeats
// aggregated.
#pragma once

#include <vector>

#include "encoding.hpp"
#include "repose/surrogate/gaussian_process_options.hpp"
#include "trend.hpp"

namespace repose::surrogate {

/// n different points in lexicographic order (appended ones last), so that a fit does not depend on
/// the order of the rows. An observation j has noise variance noise_ratio w_j (in units of the
/// process variance): w = 1 where the noise is estimated, the given variance where it is known. The
/// observations at a point enter the exact likelihood by their weighted mean, its noise weight v =
/// 1/sum(1/w) and their weighted squares [Binois2018].
struct Dataset {
  Encoding encoding;
  Trend trend;
  ResponseScale response_scale = ResponseScale::linear;
  double shift = 0.0;  ///< modelled y = shift + scale * standardised
  double scale = 1.0;
  Matrix natural;             ///< n x d
  Matrix x;                   ///< n x p, encoded
  Matrix h;                   ///< n x q regression functions
  Vector y;                   ///< mean at each point, standardised
  Vector noise;               ///< v of that mean
  double within = 0.0;        ///< sum over observations of (y - mean at its point)^2 / w
  double log_repeats = 0.0;   ///< sum log w - sum log v
  double log_jacobian = 0.0;  ///< of the observations' transformation to the modelled scale
  /// Each observation in the user's order: its point, its standardised value, its w.
  std::vector<Eigen::Index> point_of_row;
  std::vector<double> value_of_row;
  std::vector<double> noise_of_row;

  Eigen::Index points() const { return x.rows(); }
  Eigen::Index dimension() const { return natural.cols(); }
  Eigen::Index observations() const { return static_cast<Eigen::Index>(value_of_row.size()); }
  double mean_noise() const;  ///< of the observations' w
  /// Row among the points, or -1.
  Eigen::Index find(const Vector& encoded) const;
  double standardised(double response) const { return (modelled_value(response) - shift) / scale; }

 private:
  double modelled_value(double response) const;
};

/// Throws InputError as GaussianProcess::fit says, all but the number of points.
Dataset make_dataset(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                     const GaussianProcessOptions& options);

/// Fills y, noise, within and log_repeats of each point from its observations.
void aggregate(Dataset& data);

/// With one observation more at a point in natural units, of average noise; the standardisation is
/// kept.
Dataset with_observation(const Dataset& data, const Vector& natural, double y, Noise noise);

}  // namespace repose::surrogate
