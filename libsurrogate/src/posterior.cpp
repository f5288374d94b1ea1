#include "posterior.hpp"

#include <fmt/format.h>

#include "repose/base/error.hpp"

namespace repose::surrogate {

Posterior::Posterior(const ModelAccess::State& s, const Matrix& natural, const Matrix* l_inverse) {
  if (natural.cols() != s.data.dimension())
    throw InputError(fmt::format("a prediction at points of {} inputs; the model has {}",
                                 natural.cols(), s.data.dimension()));
  at = s.data.encoding.encode(natural);
  const Correlator correlator = s.covariance.correlator(s.data.encoding);
  const Matrix h = trend_matrix(s.data.trend, s.data.encoding, natural, at);
  e.resize(s.sensitivity.directions(), at.rows());
  if (s.sensitivity.directions() == 0) {
    v = cross_correlation(correlator, s.data.x, at);
  } else {
    constexpr Eigen::Index kBlock = 128;  // the slopes are needed no longer
    v.resize(s.data.points(), at.rows());
    for (Eigen::Index begin = 0; begin < at.rows(); begin += kBlock) {
      const Eigen::Index size = std::min(kBlock, at.rows() - begin);
      const Matrix q = at.middleRows(begin, size);
      const CrossCorrelation k(correlator, s.data.x, q);
      e.middleCols(begin, size) =
          s.sensitivity.at(s.data, correlator, s.factor.alpha, q, h.middleRows(begin, size), k);
      v.middleCols(begin, size) = k.r;
    }
  }
  mean = h * s.factor.beta + v.transpose() * s.factor.alpha;
  if (l_inverse == nullptr)
    dense().solve_lower(s.factor.l.data(), v.rows(), v.data(), v.cols());
  else
    dense().multiply_lower(l_inverse->data(), v.rows(), v.data(), v.cols());
  t.resize(h.cols(), at.rows());
  if (h.cols() > 0)
    t = s.factor.u.transpose().triangularView<Eigen::Lower>().solve(h.transpose()) -
        s.factor.q1.transpose() * v;
}

Vector Posterior::covariance_with(const ModelAccess::State& s, Eigen::Index j) const {
  Vector c = cross_correlation(s.covariance.correlator(s.data.encoding), at, at.row(j));
  c.noalias() -= v.transpose() * v.col(j);
  c.noalias() += t.transpose() * t.col(j);
  c.noalias() += e.transpose() * e.col(j);
  return c;
}

}  // namespace repose::surrogate
