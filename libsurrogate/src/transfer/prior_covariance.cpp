#include "prior_covariance.hpp"

#include "correlation.hpp"
#include "state.hpp"

namespace repose::surrogate {

Matrix prior_correlation(const GaussianProcess& model, const Matrix& a, const Matrix& b,
                         const Vector& length_factors) {
  const auto& s = ModelAccess::state(model);
  Correlator correlator = s.covariance.correlator(s.data.encoding);
  for (Eigen::Index k = 0; k < correlator.weight.size(); ++k) {
    const double factor = length_factors[s.data.encoding.scale_of(k)];
    correlator.weight[k] /= factor * factor;
  }
  return cross_correlation(correlator, s.data.encoding.encode(a), s.data.encoding.encode(b));
}

}  // namespace repose::surrogate
