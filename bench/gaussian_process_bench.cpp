// Fits of and predictions by a Gaussian process, on sizes of a calibration.
#include <benchmark/benchmark.h>

#include <cmath>

#include "repose/base/random.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace {

using repose::Matrix;
using repose::Vector;
using repose::surrogate::GaussianProcess;

/// n points in d dimensions of a smooth function with noise.
std::pair<Matrix, Vector> data(Eigen::Index n, Eigen::Index d) {
  repose::RandomStream random(1);
  Matrix x(n, d);
  Vector y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < d; ++k) x(i, k) = random.uniform();
    y[i] = std::sin(3.0 * x(i, 0)) + x(i, 1) * x(i, 1) + 0.05 * random.normal();
  }
  return {x, y};
}

void fit(benchmark::State& state) {
  const auto [x, y] = data(state.range(0), state.range(1));
  const repose::opt::Bounds unit{Vector::Zero(x.cols()), Vector::Ones(x.cols())};
  for (auto _ : state) benchmark::DoNotOptimize(GaussianProcess::fit(x, y, unit));
}
BENCHMARK(fit)
    ->Args({100, 3})
    ->Args({185, 18})
    ->Args({200, 8})
    ->ArgNames({"n", "d"})
    ->Unit(benchmark::kMillisecond);

void predict(benchmark::State& state) {
  const auto [x, y] = data(200, 4);
  const auto model = GaussianProcess::fit(x, y, {Vector::Zero(4), Vector::Ones(4)});
  const auto points = data(10000, 4).first;
  for (auto _ : state) benchmark::DoNotOptimize(model.predict_rows(points));
  state.counters["points"] = benchmark::Counter(1e4 * static_cast<double>(state.iterations()),
                                                benchmark::Counter::kIsRate);
}
BENCHMARK(predict)->Unit(benchmark::kMillisecond);

}  // namespace
