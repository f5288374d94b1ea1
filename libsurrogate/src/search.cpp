#include "search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::surrogate {
namespace {

// Bounds of the search: length scales in units of the coordinates, noise in units of the process
// variance or of the variance of the response.
constexpr double kShortest = 0.02;
constexpr double kLongest = 1e5;
constexpr double kLeastAlpha = 1e-2;
constexpr double kMostAlpha = 1e3;
/// Of a process variance that may be 10^6 of the response's; a few roundings of the diagonal's 1,
/// below which the noise has no effect.
constexpr double kLeastNoise = 1e-15;
constexpr double kMostNoise = 1e4;
constexpr double kLeastAmplitude = 1e-10;
constexpr double kMostAmplitude = 1e12;
// Starts: the best of a grid at each noise ratio, length scales as fractions of sqrt(d) ranges;
// then jittered copies of the best.
constexpr double kGridScales[] = {0.02, 0.0632, 0.2, 0.632, 2.0};
constexpr double kGridNoise[] = {1e-8, 1e-3, 0.1};
constexpr double kGridAmplitude[] = {0.5, 5.0};
constexpr double kScaleJitter = 0.35;
constexpr double kOtherJitter = 1.5;
constexpr double kInertBelow = 0.1;  // [Gu2019]

bool is_fixed(const opt::Bounds& bounds, Eigen::Index k) {
  return bounds.lower[k] == bounds.upper[k];
}

std::vector<Eigen::Index> free_parameters(const opt::Bounds& bounds) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < bounds.lower.size(); ++k)
    if (!is_fixed(bounds, k)) free.push_back(k);
  return free;
}

struct GridPoint {
  Vector p;
  double value = 0.0;
};

/// Isotropic points, every combination of scale and amplitude, at one noise ratio: the best.
GridPoint best_of_grid(const NegativeLogPosterior& objective, const SearchSpace& space,
                       const Dataset& data, double noise_ratio, int& evaluations) {
  const Eigen::Index scales = data.encoding.scales();
  const double root = std::sqrt(static_cast<double>(data.dimension()));
  GridPoint best;
  for (const double scale : kGridScales)
    for (const double amplitude : kGridAmplitude) {
      if (!objective.searches_amplitude() && amplitude != kGridAmplitude[0]) continue;
      Vector p = Vector::Zero(objective.size());
      p.head(scales).setConstant(std::log(scale * root));
      if (objective.searches_amplitude()) p[objective.amplitude_parameter()] = std::log(amplitude);
      if (objective.estimates_noise()) p[objective.noise_parameter()] = std::log(noise_ratio);
      p = opt::project(p, space.bounds);
      const double value = objective(p, nullptr);
      ++evaluations;
      if (best.p.size() == 0 || value < best.value) best = {p, value};
    }
  return best;
}

/// The best of the grid at every noise ratio, best first. A likelihood has one optimum that takes
/// what it does not understand for noise and another that takes it for signal, and no search leaves
/// the one for the other [Rasmussen2006, section 5.4.1].
std::vector<GridPoint> best_by_noise(const NegativeLogPosterior& objective,
                                     const SearchSpace& space, const Dataset& data,
                                     int& evaluations) {
  std::vector<GridPoint> points;
  for (const double ratio : kGridNoise) {
    const GridPoint best = best_of_grid(objective, space, data, ratio, evaluations);
    const bool is_new = std::none_of(points.begin(), points.end(),
                                     [&](const GridPoint& g) { return g.p == best.p; });
    if (is_new) points.push_back(best);
    if (!objective.estimates_noise()) break;
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const GridPoint& a, const GridPoint& b) { return a.value < b.value; });
  return points;
}

/// As many of the points as there are starts, then jittered copies of the first.
Matrix make_starts(const std::vector<GridPoint>& points, Eigen::Index scales,
                   const opt::Bounds& bounds, const GaussianProcessOptions& options) {
  Matrix rows(options.starts, points[0].p.size());
  for (Eigen::Index s = 0; s < options.starts; ++s) {
    const auto index = static_cast<std::size_t>(s);
    if (index < points.size()) {
      rows.row(s) = points[index].p;
      continue;
    }
    RandomStream random(options.seed, static_cast<std::uint64_t>(s));
    Vector p = points[0].p;
    for (Eigen::Index k = 0; k < p.size(); ++k)
      p[k] += (k < scales ? kScaleJitter : kOtherJitter) * random.normal();
    rows.row(s) = opt::project(p, bounds);
  }
  return rows;
}

void set_bounds(SearchSpace& space, const ParameterBounds& wanted) {
  const auto found = std::find(space.names.begin(), space.names.end(), wanted.name);
  if (found == space.names.end())
    throw InputError(fmt::format("bounds of '{}', which is no parameter of this fit; these are: {}",
                                 wanted.name, fmt::join(space.names, ", ")));
  if (!(wanted.lower > 0.0) || !(wanted.lower <= wanted.upper) || !std::isfinite(wanted.upper))
    throw InputError(fmt::format("'{}' in [{}, {}]; bounds must be positive, finite and in order",
                                 wanted.name, wanted.lower, wanted.upper));
  const Eigen::Index k = found - space.names.begin();
  space.bounds.lower[k] = std::log(wanted.lower / space.unit[k]);
  space.bounds.upper[k] = std::log(wanted.upper / space.unit[k]);
}

ParameterState state_of(double p, double lower, double upper) {
  if (lower == upper) return ParameterState::fixed;
  if (p <= lower + kAtBound) return ParameterState::at_lower_bound;
  if (p >= upper - kAtBound) return ParameterState::at_upper_bound;
  return ParameterState::converged;
}

}  // namespace

Amplitude amplitude_of(const GaussianProcessOptions& options) {
  if (options.noise == Noise::known || options.noise == Noise::by_point) return Amplitude::searched;
  for (const ParameterBounds& b : options.bounds)
    if (b.name == "process_variance" || b.name == "noise_variance") return Amplitude::searched;
  return Amplitude::profiled;
}

SearchSpace make_search_space(const NegativeLogPosterior& objective, const Dataset& data,
                              const GaussianProcessOptions& options) {
  SearchSpace space{.names = data.encoding.scale_names(), .unit = data.encoding.scale_units()};
  const auto add = [&space](const char* name, double unit, double lower, double upper) {
    space.names.emplace_back(name);
    const auto n = static_cast<Eigen::Index>(space.names.size());
    for (Vector* v : {&space.unit, &space.bounds.lower, &space.bounds.upper})
      v->conservativeResize(n);
    space.unit[n - 1] = unit;
    space.bounds.lower[n - 1] = std::log(lower);
    space.bounds.upper[n - 1] = std::log(upper);
  };
  space.bounds.lower = Vector::Constant(data.encoding.scales(), std::log(kShortest));
  space.bounds.upper = Vector::Constant(data.encoding.scales(), std::log(kLongest));
  const double variance = data.scale * data.scale;
  if (objective.has_alpha()) add("alpha", 1.0, kLeastAlpha, kMostAlpha);
  if (objective.searches_amplitude())
    add("process_variance", variance, kLeastAmplitude, kMostAmplitude);
  if (objective.estimates_noise() && objective.searches_amplitude())
    add("noise_variance", variance, kLeastNoise, kMostNoise);
  else if (objective.estimates_noise())
    add("noise_ratio", 1.0, kLeastNoise, kMostNoise);
  for (const ParameterBounds& wanted : options.bounds) set_bounds(space, wanted);
  return space;
}

Vector default_parameters(const NegativeLogPosterior& objective, const SearchSpace& space) {
  Vector p = Vector::Zero(objective.size());
  if (objective.estimates_noise())
    p[objective.noise_parameter()] = space.bounds.lower[objective.noise_parameter()];
  return opt::project(p, space.bounds);
}

opt::Minimum search(const NegativeLogPosterior& objective, const SearchSpace& space,
                    const Dataset& data, const GaussianProcessOptions& options) {
  int evaluations = 0;
  const std::vector<GridPoint> points = best_by_noise(objective, space, data, evaluations);
  const Vector& best = points[0].p;
  const std::vector<Eigen::Index> free = free_parameters(space.bounds);
  if (free.empty())
    return {.x = best,
            .value = points[0].value,
            .termination = opt::Termination::converged,
            .message = "every parameter was given",
            .evaluations = evaluations};
  const auto complete = [&](const Vector& part) {
    Vector p = best;
    p(free) = part;
    return p;
  };
  const auto reduced = [&](const Vector& part, Vector* gradient) {
    if (gradient == nullptr) return objective(complete(part), nullptr);
    Vector full(best.size());
    const double value = objective(complete(part), &full);
    *gradient = full(free);
    return value;
  };
  const Matrix starts =
      make_starts(points, data.encoding.scales(), space.bounds, options)(Eigen::all, free);
  opt::Minimum minimum =
      opt::multi_start(reduced, starts, {space.bounds.lower(free), space.bounds.upper(free)},
                       options.minimizer, options.threads);
  minimum.x = complete(minimum.x);
  minimum.evaluations += evaluations;
  return minimum;
}

std::vector<FittedParameter> describe(const Vector& p, const SearchSpace& space,
                                      const NegativeLogPosterior& objective, const Dataset& data) {
  const Eigen::Index scales = data.encoding.scales();
  const Vector inverse = objective.mean_distance().array() / p.head(scales).array().exp();
  const double mean_inverse = inverse.mean();
  std::vector<FittedParameter> parameters;
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    FittedParameter f{.name = space.names[static_cast<std::size_t>(k)],
                      .value = space.unit[k] * std::exp(p[k]),
                      .lower = space.unit[k] * std::exp(space.bounds.lower[k]),
                      .upper = space.unit[k] * std::exp(space.bounds.upper[k]),
                      .state = state_of(p[k], space.bounds.lower[k], space.bounds.upper[k])};
    if (k < scales) {
      f.relevance = mean_inverse > 0.0 ? inverse[k] / mean_inverse : 0.0;
      if (f.relevance < kInertBelow && f.state != ParameterState::fixed)
        f.state = ParameterState::inert;
    }
    parameters.push_back(std::move(f));
  }
  return parameters;
}

}  // namespace repose::surrogate
