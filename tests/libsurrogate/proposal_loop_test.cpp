// Calibration in miniature: propose, evaluate, fit again, with Gaussian processes as surrogates.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "gp_data.hpp"
#include "repose/opt/propose.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {
namespace {

static_assert(opt::SurrogateLike<GaussianProcess>);

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
            ? opt::propose_batch(models, problem.targets, kInputs, kBatch, propose).points
            : opt::propose_batch(GaussianProcess::fit(x, y, cube, options), kInputs, kBatch,
                                 propose)
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

}  // namespace
}  // namespace repose::surrogate
