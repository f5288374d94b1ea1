// Calibration in miniature: propose, evaluate, fit again, with Gaussian processes as surrogates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "gp_data.hpp"
#include "repose/surrogate/fitter.hpp"

namespace repose::surrogate {
namespace {

static_assert(opt::SurrogateLike<GaussianProcess> && opt::HasGradient<GaussianProcess> &&
              opt::HasCovariance<GaussianProcess>);

constexpr Eigen::Index kInputs = 4;
constexpr int kKpis = 4;
constexpr int kBatches = 4;
constexpr int kBatch = 4;

/// Four smooth quantities of four parameters, with a hidden truth that the targets are taken from.
struct Synthetic {
  std::array<std::array<Vector, 3>, kKpis> slope;
  std::array<Vector, kKpis> linear;
  Vector truth;
  std::vector<opt::Target> targets;

  explicit Synthetic(std::uint64_t seed) : truth(kInputs) {
    RandomStream random(seed);
    for (int j = 0; j < kKpis; ++j) {
      const auto vector = [&](double size) {
        Vector v(kInputs);
        for (double& value : v) value = size * random.normal();
        return v;
      };
      for (Vector& s : slope[static_cast<std::size_t>(j)]) s = vector(1.2);
      linear[static_cast<std::size_t>(j)] = vector(0.8);
    }
    for (double& value : truth) value = random.uniform(0.15, 0.85);
    const std::vector<double> wanted = kpis(truth);
    for (int j = 0; j < kKpis; ++j)
      targets.push_back({.name = "kpi", .value = wanted[static_cast<std::size_t>(j)]});
  }
  std::vector<double> kpis(const Vector& x) const {
    std::vector<double> h;
    for (std::size_t j = 0; j < kKpis; ++j) {
      double value = 5.0 + linear[j].dot(x);
      for (const Vector& s : slope[j]) value += std::sin(1.5 * s.dot(x) + s[0]);
      h.push_back(value);
    }
    return h;
  }
  double error(const Vector& x) const { return opt::weighted_error(kpis(x), targets); }
};

enum class Way { composite, scalar };

/// Smallest error among all points after four batches of four, from twelve points.
double best_after_batches(const Synthetic& problem, Way way, std::uint64_t seed) {
  Matrix x = opt::scrambled_uniforms(12, kInputs, seed);
  const GaussianProcessOptions options{.noise = Noise::none, .starts = 2};
  const opt::Bounds cube = opt::unit_cube(kInputs);
  for (int batch = 0; batch < kBatches; ++batch) {
    const opt::ProposeOptions propose{.visited = x,
                                      .candidates = 500,
                                      .polished = 2,
                                      .polish_evaluations = 80,
                                      .draws = 128,
                                      .seed = seed + static_cast<std::uint64_t>(batch)};
    Vector y(x.rows());
    std::vector<opt::Surrogate> models;
    for (std::size_t j = 0; j < kKpis && way == Way::composite; ++j) {
      for (Eigen::Index i = 0; i < x.rows(); ++i) y[i] = problem.kpis(x.row(i))[j];
      models.emplace_back(GaussianProcess::fit(x, y, cube, options));
    }
    for (Eigen::Index i = 0; i < x.rows() && way == Way::scalar; ++i)
      y[i] = problem.error(x.row(i));
    const Matrix next =
        way == Way::composite
            ? opt::propose_batch(models, problem.targets, {cube}, kBatch, propose).points
            : opt::propose_batch(GaussianProcess::fit(x, y, cube, options), {cube}, kBatch, propose)
                  .points;
    Matrix all(x.rows() + next.rows(), kInputs);
    all << x, next;
    x = all;
  }
  double best = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < x.rows(); ++i) best = std::min(best, problem.error(x.row(i)));
  return best;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Astudillo & Frazier 2019 report orders of magnitude; a factor three in the median is asked for
// here.
TEST(CompositeProposals, ReachThreeTimesLessErrorThanAModelOfTheWeightedError) {
  std::vector<double> composite;
  std::vector<double> scalar;
  for (std::uint64_t seed = 1; seed <= 7; ++seed) {
    const Synthetic problem(seed);
    composite.push_back(best_after_batches(problem, Way::composite, 100 * seed));
    scalar.push_back(best_after_batches(problem, Way::scalar, 100 * seed));
  }
  EXPECT_LT(3.0 * median(composite), median(scalar));
  RecordProperty("composite", std::to_string(median(composite)));
  RecordProperty("scalar", std::to_string(median(scalar)));
}

TEST(GaussianProcessProposals, RepeatTheSameBits) {
  const Synthetic problem(3);
  EXPECT_EQ(best_after_batches(problem, Way::composite, 5),
            best_after_batches(problem, Way::composite, 5));
}

TEST(GaussianProcessProposals, TakePendingRepeatsOfKnownPointsWhateverIsBelieved) {
  const Matrix x = opt::scrambled_uniforms(8, 2, 3);
  const Vector y = x.rowwise().sum();
  const auto model =
      GaussianProcess::fit(x, y, opt::unit_cube(2), GaussianProcessOptions{.noise = Noise::none});
  for (const opt::Belief belief : {opt::Belief::kriging, opt::Belief::best_lie,
                                   opt::Belief::mean_lie, opt::Belief::worst_lie}) {
    const auto p = opt::propose_batch(model, {opt::unit_cube(2)}, 2,
                                      {.visited = x, .pending = x.topRows(2), .belief = belief});
    EXPECT_TRUE(p.points.allFinite());
  }
}

TEST(SurrogateInCoordinates, HasTheDerivativesOfThoseCoordinates) {
  const ParameterSpace parameters(
      {{.name = "young_pa", .lower = 1e6, .upper = 1e9, .scale = Scale::log},
       {.name = "friction", .lower = 0.1, .upper = 0.9}});
  const opt::SearchSpace space(parameters);
  const Matrix z =
      space.coordinates_rows(parameters.from_unit_rows(opt::scrambled_uniforms(20, 2, 5)));
  const Matrix x = space.natural_rows(z);
  Vector y(20);
  for (Eigen::Index i = 0; i < 20; ++i) y[i] = std::sin(3.0 * z(i, 0)) + std::exp(z(i, 1));
  const auto model = gaussian_process_fitter(parameters, {.noise = Noise::none})(x, y)[0];
  const opt::Surrogate surrogate = space.in_coordinates(model);
  ASSERT_TRUE(surrogate.has_gradient());
  const Vector at{{std::log(4e7), 0.43}};
  EXPECT_EQ(surrogate.predict(at).mean, model.predict(space.natural(at)).mean);
  const auto g = surrogate.predict_gradient(at);
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double h = 1e-4;  // central differences: h^2 of truncation, 1e-13/h of rounding
    Vector up = at, down = at;
    up[k] += h;
    down[k] -= h;
    const Gaussian a = surrogate.predict(up), b = surrogate.predict(down);
    EXPECT_NEAR(g.mean[k], (a.mean - b.mean) / (2.0 * h), 1e-6);
    EXPECT_NEAR(g.standard_deviation[k],
                (a.standard_deviation() - b.standard_deviation()) / (2.0 * h), 1e-5);
  }
}

// Stiffness on a log scale, whole layers, a category and a target with a failure region.
TEST(GaussianProcessFitter, DrivesAskAndTellOverParametersOfAllKinds) {
  const ParameterSpace space(
      {{.name = "friction", .lower = 0.1, .upper = 0.9},
       {.name = "young_pa", .lower = 1e6, .upper = 1e9, .scale = Scale::log},
       {.name = "layers", .lower = 1, .upper = 4, .kind = ParameterKind::integer},
       {.name = "mode", .kind = ParameterKind::categorical, .categories = {"wet", "dry"}}});
  const auto angle = [](const Vector& x) {
    return 20.0 + 25.0 * x[0] - 1.5 * std::log10(x[1] / 1e6) + x[2] + 2.0 * x[3];
  };
  opt::BayesianOptimizer optimizer(
      {.parameters = space, .responses = {"angle"}, .targets = {{.name = "angle", .value = 38.0}}},
      gaussian_process_fitter(space, {.noise = Noise::none}));
  for (int round = 0; round < 5; ++round)
    for (const opt::Trial& trial : optimizer.ask(4)) {
      if (trial.x[0] > 0.85)
        optimizer.tell_failed(trial.id);
      else
        optimizer.tell(trial.id, Vector::Constant(1, angle(trial.x)));
    }
  EXPECT_NEAR(angle(optimizer.recommend().x), 38.0, 0.01);
}

}  // namespace
}  // namespace repose::surrogate
