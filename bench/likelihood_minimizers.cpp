// Which minimiser for the likelihood: the figures of docs/decisions/0007-own-lbfgs.md.
//   repose_likelihood_minimizers
// Every fit gives the same ten starts to every method; a start counts as good within 1e-3 or
// 0.5 nat of the smallest value that any method found from any start of the same fit.
#include <fmt/format.h>
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "repose/base/random.hpp"
#include "repose/opt/minimizer.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace {

using namespace repose;
using surrogate::GaussianProcess;
using surrogate::GaussianProcessOptions;

struct Data {
  std::string name;
  Matrix x;
  Vector y;
};

Data from_file(const std::string& name, Eigen::Index inputs, Eigen::Index output) {
  std::ifstream in(std::string(REPOSE_SOURCE_DIR) + "/tests/data/gp/ds_" + name + "d.csv");
  std::vector<std::vector<double>> rows;
  std::string line, cell;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::stringstream cells(line);
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  Data data{name + " y" + std::to_string(output + 1),
            Matrix(static_cast<Eigen::Index>(rows.size()), inputs),
            Vector(static_cast<Eigen::Index>(rows.size()))};
  for (Eigen::Index i = 0; i < data.x.rows(); ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < inputs; ++k) data.x(i, k) = row[static_cast<std::size_t>(k) + 1];
    data.y[i] = row[static_cast<std::size_t>(inputs + output) + 1];
  }
  return data;
}

/// A smooth function of the first inputs with noise; the last third of the inputs is inert.
Data noisy_sines(Eigen::Index n, Eigen::Index d, double noise, std::uint64_t seed) {
  RandomStream random(seed);
  Data data{fmt::format("random {} x {}, noise {}, {}", n, d, noise, seed), Matrix(n, d),
            Vector(n)};
  Vector weight(d), phase(d);
  for (Eigen::Index k = 0; k < d; ++k) {
    weight[k] = k < 2 * d / 3 + 1 ? 1.0 + 4.0 * random.uniform() : 0.0;
    phase[k] = 6.0 * random.uniform();
  }
  for (double& value : data.x.reshaped()) value = random.uniform();
  for (Eigen::Index i = 0; i < n; ++i) {
    data.y[i] = noise * random.normal();
    for (Eigen::Index k = 0; k < d; ++k)
      data.y[i] +=
          std::sin(weight[k] * data.x(i, k) + phase[k]) * (1.0 + (k > 0 ? data.x(i, k - 1) : 0.0));
  }
  return data;
}

/// The data of bench/gaussian_process_bench.cpp.
Data bench_data(Eigen::Index n, Eigen::Index d) {
  RandomStream random(1);
  Data data{fmt::format("bench {} x {}", n, d), Matrix(n, d), Vector(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < d; ++k) data.x(i, k) = random.uniform();
    data.y[i] = std::sin(3.0 * data.x(i, 0)) + data.x(i, 1) * data.x(i, 1) + 0.05 * random.normal();
  }
  return data;
}

struct Method {
  std::string name;
  std::string first;  ///< how messages begin unless another method took over
  opt::Minimizer minimizer;
};

/// What all methods found from one start, in their order.
using Ends = std::vector<opt::Minimum>;

/// Runs all methods from every start it is given and returns the best.
struct Referee {
  const std::vector<Method>* methods;
  std::vector<Ends>* starts;
  opt::Minimum minimize(const opt::Objective& f, const Vector& x, const opt::Bounds& b) const {
    Ends ends;
    for (const Method& m : *methods) ends.push_back(m.minimizer.minimize(f, x, b));
    starts->push_back(ends);
    return *std::min_element(ends.begin(), ends.end(),
                             [](const auto& p, const auto& q) { return p.value < q.value; });
  }
};

constexpr double kRelativeX = 1e-7, kRelativeF = 1e-10;
constexpr int kMaxEvaluations = 500;

opt::BuiltinMinimizer method(opt::Algorithm algorithm, double curvature = 0.0) {
  return {{.algorithm = algorithm,
           .relative_x_tolerance = kRelativeX,
           .relative_f_tolerance = kRelativeF,
           .max_evaluations = kMaxEvaluations,
           .initial_curvature = curvature}};
}

/// NLopt's own L-BFGS, which the library had before; no method takes over where it fails.
struct NloptLbfgs {
  struct Call {
    const opt::Objective* objective;
    opt::Minimum best;
  };
  static double call(unsigned n, const double* x, double* gradient, void* data) {
    auto& self = *static_cast<Call*>(data);
    const auto size = static_cast<Eigen::Index>(n);
    Vector g = Vector::Zero(size);
    const Vector at = Eigen::Map<const Vector>(x, size);
    const double value = (*self.objective)(at, &g);
    ++self.best.evaluations;
    if (gradient != nullptr) Eigen::Map<Vector>(gradient, size) = g;
    if (!std::isfinite(value)) return 1e10;
    if (value < self.best.value) {
      self.best.value = value;
      self.best.x = at;
    }
    return value;
  }
  opt::Minimum minimize(const opt::Objective& f, const Vector& x, const opt::Bounds& b) const {
    Call data{&f, {x, std::numeric_limits<double>::infinity()}};
    nlopt_opt handle = nlopt_create(NLOPT_LD_LBFGS, static_cast<unsigned>(x.size()));
    const Vector absolute = 1e-10 * (b.upper - b.lower);
    nlopt_set_lower_bounds(handle, b.lower.data());
    nlopt_set_upper_bounds(handle, b.upper.data());
    nlopt_set_min_objective(handle, call, &data);
    nlopt_set_xtol_rel(handle, kRelativeX);
    nlopt_set_xtol_abs(handle, absolute.data());
    nlopt_set_ftol_rel(handle, kRelativeF);
    nlopt_set_maxeval(handle, kMaxEvaluations);
    Vector at = x;
    double value = 0.0;
    const nlopt_result result = nlopt_optimize(handle, at.data(), &value);
    nlopt_destroy(handle);
    data.best.message = result > 0 ? "nlopt" : "failed";
    return data.best;
  }
};

std::vector<Method> methods() {
  return {{"NLopt L-BFGS alone", "nlopt", NloptLbfgs{}},
          {"NLopt SLSQP", "slsqp", method(opt::Algorithm::slsqp)},
          {"L-BFGS", "lbfgs", method(opt::Algorithm::lbfgs)},
          {"L-BFGS, curvature 1", "lbfgs", method(opt::Algorithm::lbfgs, 1.0)}};
}

struct Score {
  int fits = 0, good_fits = 0, starts = 0, within_thousandth = 0, within_half = 0, gave_up = 0;
  long evaluations = 0;
};

void count(const std::vector<Ends>& starts, const std::vector<Method>& all,
           std::vector<Score>& scores) {
  double best = std::numeric_limits<double>::infinity();
  for (const Ends& ends : starts)
    for (const opt::Minimum& m : ends) best = std::min(best, m.value);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Score& s = scores[i];
    double of_five = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < starts.size(); ++k) {
      const opt::Minimum& m = starts[k][i];
      if (k < 5) of_five = std::min(of_five, m.value);
      ++s.starts;
      s.within_thousandth += m.value <= best + 1e-3 ? 1 : 0;
      s.within_half += m.value <= best + 0.5 ? 1 : 0;
      s.gave_up += m.message.starts_with(all[i].first) ? 0 : 1;
      s.evaluations += m.evaluations;
    }
    ++s.fits;
    s.good_fits += of_five <= best + 0.5 ? 1 : 0;
  }
}

GaussianProcessOptions deterministic_ml() {
  return {.noise = surrogate::Noise::none,
          .estimator = surrogate::Estimator::ml,
          .prior = surrogate::Prior::none,
          .starts = 10};
}

void compare(const std::string& name, const std::vector<Data>& sets,
             GaussianProcessOptions options) {
  const std::vector<Method> all = methods();
  std::vector<Score> scores(all.size());
  for (const Data& data : sets) {
    std::vector<Ends> starts;
    options.minimizer = Referee{&all, &starts};
    GaussianProcess::fit(data.x, data.y, {data.x.colwise().minCoeff(), data.x.colwise().maxCoeff()},
                         options);
    count(starts, all, scores);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Score& s = scores[i];
    fmt::print("| {} | {} | {:.1f} | {:.1f} | {}/{} | {:.1f} | {} |\n", name, all[i].name,
               100.0 * s.within_thousandth / s.starts, 100.0 * s.within_half / s.starts,
               s.good_fits, s.fits, static_cast<double>(s.evaluations) / s.starts, s.gave_up);
  }
}

}  // namespace

int main() {
  using surrogate::Estimator, surrogate::Noise, surrogate::Prior;
  std::vector<Data> files = {from_file("branin_10", 2, 0), from_file("borehole_10", 8, 0)};
  for (Eigen::Index k = 0; k < 6; ++k) files.push_back(from_file("weldedbeamdesign_10", 4, k));
  for (Eigen::Index k = 0; k < 3; ++k) files.push_back(from_file("g10mod_5", 8, k));
  std::vector<Data> exact, noisy;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const Eigen::Index n = seed % 2 == 0 ? 40 : 80, d = seed % 2 == 0 ? 4 : 8;
    exact.push_back(noisy_sines(n, d, 0.0, seed));
    noisy.push_back(noisy_sines(n, d, 0.1, seed));
  }
  GaussianProcessOptions squared{.starts = 10};
  squared.kernel = surrogate::kernel_named("ard-squared-exponential");
  const GaussianProcessOptions ml = deterministic_ml();

  fmt::print(
      "| data and model | method | within 10⁻³, % | within 0.5, % | fits of five starts | "
      "evaluations a start | gave up |\n|---|---|---|---|---|---|---|\n");
  compare("files, ML, no noise", files, ml);
  compare("files, REML, no noise", files,
          {.noise = Noise::none, .prior = Prior::none, .starts = 10});
  compare("files, ML, noise", files,
          {.estimator = Estimator::ml, .prior = Prior::none, .starts = 10});
  compare("files, defaults", files, {.starts = 10});
  compare("sines, ML, no noise", exact, ml);
  compare("sines with noise, defaults", noisy, {.starts = 10});
  compare("sines with noise, squared exponential", noisy, squared);
  compare("two of 18 or 12 inputs, squared exponential",
          {bench_data(185, 18), bench_data(120, 18), bench_data(60, 12)}, squared);
}
