#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "phases.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/propose.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::uint64_t kProposalStream = 100;

bool trains(const Study& study, const Point& point) {
  return point.phase != Phase::verification && point.phase != Phase::baseline &&
         (point.phase != Phase::screening || study.sampling.use_screening_runs);
}

std::vector<Eigen::Index> columns_of(const Study& study, const std::vector<std::string>& names) {
  const auto all = study.space.names();
  std::vector<Eigen::Index> columns;
  for (const auto& name : names) {
    const auto it = std::find(all.begin(), all.end(), name);
    REPOSE_ASSERT(it != all.end(), name);
    columns.push_back(it - all.begin());
  }
  return columns;
}

/// R^2 of left-out points: the mean at every place against its prediction without the runs there.
double r2_of_points(const surrogate::GaussianProcess& model, const Matrix& x, const Vector& y) {
  const auto loo = model.leave_one_out();
  struct Sum {
    double y = 0.0, predicted = 0.0;
    int n = 0;
  };
  std::map<std::vector<double>, Sum> places;
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    if (!std::isfinite(loo.predicted[i])) continue;
    std::vector<double> place(static_cast<std::size_t>(x.cols()));
    for (Eigen::Index k = 0; k < x.cols(); ++k) place[static_cast<std::size_t>(k)] = x(i, k);
    auto& sum = places[place];
    sum.y += y[i];
    sum.predicted += loo.predicted[i];
    ++sum.n;
  }
  double mean = 0.0;
  for (const auto& [place, sum] : places) mean += sum.y / sum.n;
  mean /= static_cast<double>(places.size());
  double total = 0.0, residual = 0.0;
  for (const auto& [place, sum] : places) {
    total += std::pow(sum.y / sum.n - mean, 2);
    residual += std::pow((sum.y - sum.predicted) / sum.n, 2);
  }
  return total > 0.0 ? 1.0 - residual / total : 0.0;
}

std::vector<opt::Surrogate> as_surrogates(const SurrogateSet& set) {
  std::vector<opt::Surrogate> surrogates;
  for (const auto& model : set.models) surrogates.emplace_back(model);
  return surrogates;
}

}  // namespace

Matrix project(const Study& study, const std::vector<std::string>& names, const Matrix& full_unit) {
  const auto columns = columns_of(study, names);
  Matrix reduced(full_unit.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    reduced.col(static_cast<Eigen::Index>(j)) = full_unit.col(columns[j]);
  return reduced;
}

Matrix embed(const Study& study, const std::vector<std::string>& names,
             const Matrix& reduced_unit) {
  const auto columns = columns_of(study, names);
  Matrix full = Matrix::Constant(reduced_unit.rows(),
                                 static_cast<Eigen::Index>(study.space.dimension()), 0.5);
  for (std::size_t j = 0; j < columns.size(); ++j)
    full.col(columns[j]) = reduced_unit.col(static_cast<Eigen::Index>(j));
  return full;
}

namespace {

/// The runs that have a value of a KPI: their places over `parameters`, one a row, and the values.
struct TrainingData {
  Matrix x;
  Vector y;
};
TrainingData training_data(const Study& study, const Dataset& data,
                           const std::vector<std::string>& parameters, const std::string& kpi) {
  std::vector<std::pair<const Point*, double>> rows;
  for (const auto& o : data.observations)
    if (const auto value = o.kpi(kpi); value && trains(study, data.points[o.point]))
      rows.emplace_back(&data.points[o.point], *value);
  if (rows.size() < 2 * (parameters.size() + 1))
    throw SimulationError(
        fmt::format("only {} of {} runs have a value of {}, too few to learn from; {}; choose "
                    "ranges in which the material flows",
                    rows.size(), data.observations.size(), kpi, failure_summary(data)));
  Matrix full(static_cast<Eigen::Index>(rows.size()),
              static_cast<Eigen::Index>(study.space.dimension()));
  Vector y(full.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    full.row(static_cast<Eigen::Index>(i)) = rows[i].first->unit.transpose();
    y[static_cast<Eigen::Index>(i)] = rows[i].second;
  }
  return {.x = project(study, parameters, full), .y = std::move(y)};
}

}  // namespace

SurrogateSet fit_surrogates(const Study& study, const Dataset& data,
                            const std::vector<std::string>& parameters) {
  const auto d = static_cast<Eigen::Index>(parameters.size());
  const opt::Bounds unit{Vector::Zero(d), Vector::Ones(d)};
  auto options = study.surrogate;
  options.seed = study.seed;
  options.threads = study.compute.workers;
  SurrogateSet set;
  set.parameters = parameters;
  for (const auto& target : study.targets) {
    auto [x, y] = training_data(study, data, parameters, target.target.name);
    set.models.push_back(surrogate::GaussianProcess::fit(x, y, unit, options));
    set.r2.push_back(r2_of_points(set.models.back(), x, y));
    set.x.push_back(std::move(x));
    set.y.push_back(std::move(y));
  }
  return set;
}

VisitedPoints visited_points(const Study& study, const Dataset& data,
                             const std::vector<std::string>& names) {
  std::vector<bool> usable(data.points.size(), false);
  for (const auto& o : data.observations)
    if (!o.outcome.failed()) usable[o.point] = true;
  std::vector<Vector> good, bad;
  for (std::size_t p = 0; p < data.points.size(); ++p)
    if (trains(study, data.points[p])) (usable[p] ? good : bad).push_back(data.points[p].unit);
  const auto stacked = [&](const std::vector<Vector>& points) {
    Matrix full(static_cast<Eigen::Index>(points.size()),
                static_cast<Eigen::Index>(study.space.dimension()));
    for (std::size_t i = 0; i < points.size(); ++i)
      full.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
    return project(study, names, full);
  };
  return {.usable = stacked(good), .failed = stacked(bad)};
}

double best_expected_error(const Study& study, const SurrogateSet& surrogates,
                           const Matrix& points) {
  const auto targets = study.plain_targets();
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::vector<Gaussian>> predictions;
  for (const auto& model : surrogates.models) predictions.push_back(model.predict_rows(points));
  std::vector<Gaussian> kpis(targets.size());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    for (std::size_t j = 0; j < kpis.size(); ++j)
      kpis[j] = predictions[j][static_cast<std::size_t>(i)];
    best = std::min(best, opt::weighted_error(std::span<const Gaussian>(kpis), targets).mean);
  }
  return best;
}

Matrix propose(const Study& study, const SurrogateSet& surrogates, const VisitedPoints& visited,
               int batch) {
  const auto targets = study.plain_targets();
  const auto models = as_surrogates(surrogates);
  opt::ProposeOptions options;
  options.visited = visited.usable;
  options.failed = visited.failed;
  options.seed = derive_seed(study.seed, kProposalStream + static_cast<std::uint64_t>(batch));
  options.threads = study.compute.workers;
  const auto dimension = static_cast<Eigen::Index>(surrogates.parameters.size());
  return opt::propose_batch(models, targets, {opt::unit_cube(dimension)}, study.adaptive.batch,
                            options)
      .points;
}

}  // namespace repose::dem_adapter
