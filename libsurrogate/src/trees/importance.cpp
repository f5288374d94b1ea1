#include "importance.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::surrogate {
namespace {

double mean_square(const Regressor& model, const Matrix& x, const TrainingSet& data) {
  const Vector squares = (data.y - model.predict(x)).cwiseAbs2();
  return data.weights.size() > 0 ? data.weights.dot(squares) / data.weights.sum() : squares.mean();
}

}  // namespace

std::vector<Importance> trees::importance_of(const Matrix& increase) {
  const auto n = static_cast<double>(increase.rows());
  std::vector<Importance> result;
  for (const auto& column : increase.colwise()) {
    const double mean = column.mean();
    const double squares = (column.array() - mean).square().sum();
    result.push_back({mean, std::sqrt(squares / (n * (n - 1.0)))});
  }
  return result;
}

std::vector<Importance> permutation_importance(const Regressor& model, const TrainingSet& data,
                                               const ImportanceOptions& options) {
  check(data);
  if (options.permutations < 2)
    throw InputError(
        fmt::format("{} permutations; there must be at least 2", options.permutations));
  const double before = mean_square(model, data.x, data);
  Matrix x = data.x;
  Matrix increase(options.permutations, data.dimension());
  for (Eigen::Index k = 0; k < data.dimension(); ++k) {
    std::vector<double> values(data.x.col(k).begin(), data.x.col(k).end());
    for (Eigen::Index p = 0; p < options.permutations; ++p) {
      RandomStream random(options.seed, static_cast<std::uint64_t>(k * options.permutations + p));
      random.shuffle(values);
      x.col(k) = Eigen::Map<const Vector>(values.data(), data.rows());
      increase(p, k) = mean_square(model, x, data) - before;
    }
    x.col(k) = data.x.col(k);
  }
  return trees::importance_of(increase);
}

}  // namespace repose::surrogate
