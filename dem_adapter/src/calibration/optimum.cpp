#include <algorithm>
#include <cmath>
#include <limits>

#include "phases.hpp"
#include "repose/base/random.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::uint64_t kGeneticStream = 200, kRangeStream = 201;
constexpr Eigen::Index kRangePoints = 4096;

/// Mean and deviation of the weighted error at each row.
std::vector<Gaussian> weighted_errors(const Study& study, const SurrogateSet& surrogates,
                                      const Matrix& points) {
  const auto targets = study.plain_targets();
  std::vector<std::vector<Gaussian>> predictions;
  for (const auto& model : surrogates.models) predictions.push_back(model.predict_rows(points));
  std::vector<Gaussian> errors(static_cast<std::size_t>(points.rows()));
  std::vector<Gaussian> kpis(targets.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    for (std::size_t j = 0; j < kpis.size(); ++j) kpis[j] = predictions[j][i];
    errors[i] = opt::weighted_error(std::span<const Gaussian>(kpis), targets);
  }
  return errors;
}

double nearest(const Matrix& points, const Vector& x) {
  double distance = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    distance = std::min(distance, (points.row(i).transpose() - x).cwiseAbs().maxCoeff());
  return distance;
}

/// Whether the nearest simulated point is one at which every run failed.
bool fails_nearby(const VisitedPoints& visited, const Vector& x) {
  return visited.failed.rows() > 0 && nearest(visited.failed, x) < nearest(visited.usable, x);
}

/// Quasi-random points of the whole cube and of ever smaller boxes around the optimum.
Matrix range_points(const Vector& optimum, std::uint64_t seed) {
  const std::vector<double> half_widths{1.0, 0.3, 0.1, 0.03};
  const auto d = optimum.size();
  Matrix points(static_cast<Eigen::Index>(half_widths.size()) * kRangePoints, d);
  const Matrix uniforms = opt::scrambled_uniforms(kRangePoints, d, seed);
  for (std::size_t level = 0; level < half_widths.size(); ++level) {
    const Vector low = (optimum.array() - half_widths[level]).cwiseMax(0.0);
    const Vector high = (optimum.array() + half_widths[level]).cwiseMin(1.0);
    points.middleRows(static_cast<Eigen::Index>(level) * kRangePoints, kRangePoints) =
        (uniforms.array().rowwise() * (high - low).transpose().array()).rowwise() +
        low.transpose().array();
  }
  return points;
}

}  // namespace

Optimum optimise(const Study& study, const SurrogateSet& surrogates, const VisitedPoints& visited) {
  const auto d = static_cast<Eigen::Index>(surrogates.parameters.size());
  auto options = study.genetic;
  options.seed = derive_seed(study.seed, kGeneticStream);
  const auto objective = [&](const Matrix& rows) {
    const auto errors = weighted_errors(study, surrogates, rows);
    Vector values(rows.rows());
    for (std::size_t i = 0; i < errors.size(); ++i)
      values[static_cast<Eigen::Index>(i)] =
          fails_nearby(visited, rows.row(static_cast<Eigen::Index>(i)).transpose())
              ? std::numeric_limits<double>::infinity()
              : errors[i].mean;
    return values;
  };
  const auto found =
      opt::minimize_genetic(objective, {{Vector::Zero(d), Vector::Ones(d)}}, options);
  const auto at_optimum = weighted_errors(study, surrogates, found.x.transpose());
  return {
      .unit = found.x,
      .expected_error = found.value,
      .deviation = at_optimum.front().standard_deviation(),
  };
}

std::vector<CalibratedParameter> parameter_ranges(const Study& study,
                                                  const SurrogateSet& surrogates,
                                                  const VisitedPoints& visited,
                                                  const Optimum& optimum) {
  const Matrix points = range_points(optimum.unit, derive_seed(study.seed, kRangeStream));
  const auto errors = weighted_errors(study, surrogates, points);
  Vector lowest = optimum.unit, highest = optimum.unit;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i].mean > optimum.expected_error + optimum.deviation) continue;
    const Vector point = points.row(static_cast<Eigen::Index>(i)).transpose();
    if (fails_nearby(visited, point)) continue;
    lowest = lowest.cwiseMin(point);
    highest = highest.cwiseMax(point);
  }
  const auto natural = [&](const Vector& unit) {
    return study.space.from_unit(
        embed(study, surrogates.parameters, unit.transpose()).row(0).transpose());
  };
  const Vector value = natural(optimum.unit), low = natural(lowest), high = natural(highest);
  std::vector<CalibratedParameter> result;
  for (std::size_t i = 0; i < study.space.dimension(); ++i) {
    const auto& name = study.space.parameters()[i].name;
    const auto k = static_cast<Eigen::Index>(i);
    const auto it = std::find(surrogates.parameters.begin(), surrogates.parameters.end(), name);
    const bool selected = it != surrogates.parameters.end();
    CalibratedParameter p{.name = name,
                          .value = value[k],
                          .selected = selected,
                          .lowest = low[k],
                          .highest = high[k]};
    if (selected) {
      const auto j = it - surrogates.parameters.begin();
      p.range_share = highest[j] - lowest[j];
    }
    result.push_back(p);
  }
  return result;
}

}  // namespace repose::dem_adapter
