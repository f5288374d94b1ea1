#include "repose/opt/bayesian_optimizer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::opt {
namespace {

/// Below, no surrogate is asked for.
constexpr Eigen::Index kFewestRuns = 2;
constexpr Eigen::Index kLongestSequence = 1 << 18;

Matrix stacked(const std::vector<Vector>& rows, Eigen::Index columns) {
  Matrix m(static_cast<Eigen::Index>(rows.size()), columns);
  for (std::size_t i = 0; i < rows.size(); ++i) m.row(static_cast<Eigen::Index>(i)) = rows[i];
  return m;
}

void check(const OptimizationProblem& problem, const BayesianOptimizationOptions& options) {
  if (problem.responses.empty()) throw InputError("no response to optimise");
  if (problem.targets.empty() && problem.responses.size() > 1)
    throw InputError(fmt::format("{} responses without targets; only one can be minimised",
                                 problem.responses.size()));
  if (!problem.targets.empty()) {
    check_targets(problem.targets);
    if (problem.targets.size() != problem.responses.size())
      throw InputError(fmt::format("{} targets for {} responses; there must be one for each",
                                   problem.targets.size(), problem.responses.size()));
    for (std::size_t j = 0; j < problem.targets.size(); ++j)
      if (problem.targets[j].name != problem.responses[j])
        throw InputError(fmt::format("target {} is of '{}', response {} is '{}'", j + 1,
                                     problem.targets[j].name, j + 1, problem.responses[j]));
  }
  if (options.initial_points < 0)
    throw InputError(
        fmt::format("{} initial points; there must be none or more", options.initial_points));
}

}  // namespace

const char* to_string(TrialState state) {
  constexpr const char* kNames[] = {"pending", "done", "failed"};
  return kNames[static_cast<int>(state)];
}

BayesianOptimizer::BayesianOptimizer(OptimizationProblem problem, SurrogateFitter fitter,
                                     BayesianOptimizationOptions options)
    : problem_(std::move(problem)),
      space_(problem_.parameters),
      fitter_(std::move(fitter)),
      options_(std::move(options)) {
  check(problem_, options_);
  if (options_.initial_points == 0)
    options_.initial_points = std::max(2 * static_cast<int>(space_.dimension()) + 2, 10);
}

Matrix BayesianOptimizer::points_in(TrialState state) const {
  std::vector<Vector> rows;
  for (const Trial& trial : trials_)
    if (trial.state == state) rows.push_back(trial.x);
  return stacked(rows, space_.dimension());
}

Matrix BayesianOptimizer::responses() const {
  std::vector<Vector> rows;
  for (const Trial& trial : trials_)
    if (trial.state == TrialState::done) rows.push_back(trial.y);
  return stacked(rows, static_cast<Eigen::Index>(problem_.responses.size()));
}

/// The next of one sequence, without those that break a constraint or were asked for before, while
/// others are left.
Matrix BayesianOptimizer::initial_points(int count) const {
  const ParameterSpace& parameters = problem_.parameters;
  const auto wanted = static_cast<std::size_t>(count);
  std::vector<Vector> chosen;
  std::vector<Vector> repeated;
  for (Eigen::Index size = 64; chosen.size() < wanted && size <= kLongestSequence; size *= 4) {
    const Matrix unit = scrambled_uniforms(size, space_.dimension(), options_.seed);
    chosen.clear();
    repeated.clear();
    for (Eigen::Index i = 0; i < size && chosen.size() < wanted; ++i) {
      const Vector x = parameters.from_unit(unit.row(i));
      if (!parameters.obeys_constraints(x)) continue;
      const bool known = std::any_of(trials_.begin(), trials_.end(),
                                     [&x](const Trial& trial) { return trial.x == x; }) ||
                         std::find(chosen.begin(), chosen.end(), x) != chosen.end();
      (known ? repeated : chosen).push_back(x);
    }
  }
  if (chosen.empty() && repeated.empty())
    throw InputError(fmt::format(
        "none of {} points of the ranges obeys the constraints; they leave too little of them",
        kLongestSequence));
  for (std::size_t i = 0; chosen.size() < wanted; ++i)
    chosen.push_back(repeated.empty() ? chosen[i] : repeated[i % repeated.size()]);
  return stacked(chosen, space_.dimension());
}

/// Empty where what is done does not suffice for the models yet.
std::vector<Surrogate> BayesianOptimizer::surrogates(const Matrix& done) const {
  if (done.rows() < kFewestRuns) return {};
  std::vector<Surrogate> surrogates;
  try {
    for (const Surrogate& s : fitter_(done, responses()))
      surrogates.push_back(space_.in_coordinates(s));
  } catch (const InputError&) {
    if (done.rows() >= options_.initial_points) throw;
    return {};
  }
  if (surrogates.size() != problem_.responses.size())
    throw InputError(fmt::format("the fitter gave {} surrogates for {} responses",
                                 surrogates.size(), problem_.responses.size()));
  return surrogates;
}

std::vector<Trial> BayesianOptimizer::ask(int count) {
  if (count < 1) throw InputError(fmt::format("{} trials; ask for at least 1", count));
  const Matrix done = points_in(TrialState::done);
  const auto left =
      static_cast<int>(std::max<std::int64_t>(0, options_.initial_points - initial_asked_));
  int initial = std::min(count, left);
  std::vector<Surrogate> models;
  if (initial < count) models = surrogates(done);
  if (models.empty()) initial = count;
  std::vector<Trial> asked;
  const auto append = [&](const Vector& x, double merit) {
    asked.push_back({.id = static_cast<std::int64_t>(trials_.size() + asked.size()) + 1,
                     .x = x,
                     .merit = merit});
  };
  if (initial > 0)
    for (const Matrix points = initial_points(initial); const auto& row : points.rowwise())
      append(row, std::numeric_limits<double>::quiet_NaN());
  if (initial < count) {
    ProposeOptions propose = options_.propose;
    propose.visited = space_.coordinates_rows(done);
    propose.failed = space_.coordinates_rows(points_in(TrialState::failed));
    Matrix pending = points_in(TrialState::pending);
    const Eigen::Index before = pending.rows();
    pending.conservativeResize(before + initial, space_.dimension());
    for (Eigen::Index i = 0; i < initial; ++i)
      pending.row(before + i) = asked[static_cast<std::size_t>(i)].x;
    propose.pending = space_.coordinates_rows(pending);
    propose.seed = derive_seed(options_.seed, static_cast<std::uint64_t>(trials_.size()));
    const Proposal proposal =
        problem_.targets.empty()
            ? propose_batch(models[0], space_.set(), count - initial, propose)
            : propose_batch(models, problem_.targets, space_.set(), count - initial, propose);
    for (Eigen::Index i = 0; i < proposal.points.rows(); ++i) {
      const auto index = static_cast<std::size_t>(i);
      append(proposal.repeat[index] ? visited_at(proposal.points.row(i))
                                    : space_.natural(proposal.points.row(i)),
             proposal.merit[index]);
    }
  }
  trials_.insert(trials_.end(), asked.begin(), asked.end());
  initial_asked_ += initial;
  return asked;
}

/// The bits that were told, which a way through coordinates would change.
Vector BayesianOptimizer::visited_at(const Vector& coordinates) const {
  for (const Trial& trial : trials_)
    if (trial.state == TrialState::done && space_.coordinates(trial.x) == coordinates)
      return trial.x;
  return space_.natural(coordinates);
}

Trial& BayesianOptimizer::pending_trial(std::int64_t id) {
  if (id < 1 || id > static_cast<std::int64_t>(trials_.size()))
    throw InputError(fmt::format("there is no trial {}; {} were asked for", id, trials_.size()));
  Trial& trial = trials_[static_cast<std::size_t>(id - 1)];
  if (trial.state != TrialState::pending)
    throw InputError(fmt::format("trial {} is {} already", id, to_string(trial.state)));
  return trial;
}

void BayesianOptimizer::check_response(const Vector& y) const {
  if (y.size() != static_cast<Eigen::Index>(problem_.responses.size()))
    throw InputError(
        fmt::format("{} values for {} responses", y.size(), problem_.responses.size()));
  for (Eigen::Index j = 0; j < y.size(); ++j)
    if (!std::isfinite(y[j]))
      throw InputError(
          fmt::format("response {} is {}; it must be finite (report a run without a "
                      "result as failed)",
                      problem_.responses[static_cast<std::size_t>(j)], y[j]));
}

void BayesianOptimizer::tell(std::int64_t id, const Vector& y) {
  Trial& trial = pending_trial(id);
  check_response(y);
  trial.y = y;
  trial.state = TrialState::done;
}

void BayesianOptimizer::tell_failed(std::int64_t id) {
  pending_trial(id).state = TrialState::failed;
}

std::int64_t BayesianOptimizer::add(const Vector& x, const Vector& y) {
  check_response(y);
  const auto& parameters = problem_.parameters.parameters();
  if (x.size() != space_.dimension())
    throw InputError(fmt::format("a point of {} values; the space has {} parameters", x.size(),
                                 space_.dimension()));
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Parameter& p = parameters[static_cast<std::size_t>(k)];
    if (!(x[k] >= p.lower && x[k] <= p.upper))
      throw InputError(
          fmt::format("{} is {}; it must lie in [{}, {}]", p.name, x[k], p.lower, p.upper));
  }
  const Vector nearest = space_.natural(space_.coordinates(x));
  for (Eigen::Index k = 0; k < x.size(); ++k)
    if (std::abs(nearest[k] - x[k]) > 1e-9 * std::abs(x[k]))
      throw InputError(fmt::format("{} is {}; the nearest value it takes is {}",
                                   parameters[static_cast<std::size_t>(k)].name, x[k], nearest[k]));
  trials_.push_back({.id = static_cast<std::int64_t>(trials_.size()) + 1,
                     .x = x,
                     .state = TrialState::done,
                     .y = y});
  return trials_.back().id;
}

BayesianOptimizer::Recommendation BayesianOptimizer::recommend() const {
  const Matrix done = points_in(TrialState::done);
  if (done.rows() == 0) throw InputError("no trial is done yet; there is nothing to recommend");
  const std::vector<Surrogate> models = surrogates(done);
  Recommendation best{.objective = {std::numeric_limits<double>::infinity(), 0.0}};
  bool best_obeys = false;
  for (const Trial& trial : trials_) {
    if (trial.state != TrialState::done) continue;
    const Vector z = space_.coordinates(trial.x);
    std::vector<Gaussian> p;
    for (Eigen::Index j = 0; j < trial.y.size(); ++j)
      p.push_back(models.empty() ? Gaussian{trial.y[j], 0.0}
                                 : models[static_cast<std::size_t>(j)].predict(z));
    const Gaussian objective = problem_.targets.empty()
                                   ? p[0]
                                   : weighted_error(std::span<const Gaussian>(p), problem_.targets);
    const bool obeys = problem_.parameters.obeys_constraints(trial.x);
    const bool better = obeys != best_obeys ? obeys : objective.mean < best.objective.mean;
    if (std::isfinite(objective.mean) && better) {
      best = {trial.id, trial.x, objective};
      best_obeys = obeys;
    }
  }
  if (!std::isfinite(best.objective.mean))
    throw NumericalError("no finite prediction at any trial; look at the models");
  return best;
}

}  // namespace repose::opt
