// How well models of one function are adapted to another, by each way of transfer: prints the table
// of docs/validation/transfer.md. Errors, not times. repose_transfer_pairs [SEEDS] [THREADS]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>

#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/doe/space_filling.hpp"
#include "repose/surrogate/transfer.hpp"

namespace {

using namespace repose;
using namespace repose::surrogate;

constexpr Eigen::Index kInputs = 5, kSourceRows = 80, kTests = 500;
constexpr double kNoise = 1.0;
constexpr int kSizes[] = {5, 10, 20};

/// [Friedman1991]
double friedman(const Vector& x) {
  return 10.0 * std::sin(std::numbers::pi * x[0] * x[1]) + 20.0 * std::pow(x[2] - 0.5, 2) +
         10.0 * x[3] + 5.0 * x[4];
}

double another(const Vector& x) {
  return 6.0 * std::cos(3.0 * x[4]) + 8.0 * x[0] * (1.0 - x[3]) + 5.0 * std::exp(-3.0 * x[1]) +
         4.0 * x[2];
}

struct Pair {
  const char* name;
  std::function<double(const Vector&)> target;
};

std::vector<Pair> pairs() {
  return {
      {"nearly the same",
       [](const Vector& x) { return friedman(x) + 1.0 + 0.8 * std::sin(5.0 * x[0] + 2.0 * x[4]); }},
      {"scaled, with a part of its own",
       [](const Vector& x) {
         return 3.0 + 1.4 * friedman(x) + 1.5 * std::sin(4.0 * x[2]) + 2.0 * x[3] * x[1];
       }},
      {"half of each", [](const Vector& x) { return 0.6 * friedman(x) + 0.6 * another(x); }},
      {"unrelated", another},
      {"opposed", [](const Vector& x) { return 20.0 - 0.5 * friedman(x) + 0.7 * another(x); }}};
}

Vector values(const std::function<double(const Vector&)>& f, const Matrix& x) {
  Vector y(x.rows());
  for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = f(x.row(i));
  return y;
}

TrainingSet sample(const std::function<double(const Vector&)>& f, Eigen::Index rows,
                   std::uint64_t seed) {
  TrainingSet data;
  data.x = doe::latin_hypercube(static_cast<int>(rows), kInputs, {.seed = seed});
  RandomStream random(seed, 17);
  data.y = values(f, data.x);
  for (double& y : data.y) y += kNoise * random.normal();
  data.inputs.resize(kInputs);
  return data;
}

constexpr TransferMethod kMethods[] = {
    TransferMethod::retrained,    TransferMethod::target_only,    TransferMethod::shift_and_scale,
    TransferMethod::source_basis, TransferMethod::coregionalised, TransferMethod::weighted};

/// Of one pair, size and seed: the errors of all methods, then the correlation found.
std::vector<double> run(const Pair& pair, int size, std::uint64_t seed) {
  const TrainingSet source = sample(friedman, kSourceRows, seed);
  const PretrainedModel model = pretrained("gpr", source, seed);
  const TrainingSet target =
      sample(pair.target, size, 1000 * static_cast<std::uint64_t>(size) + seed);
  const Matrix x = doe::sobol_points(kTests, kInputs, {.seed = 7});
  const Vector truth = values(pair.target, x);
  std::vector<double> results;
  double correlation = 0.0;
  for (const TransferMethod method : kMethods) {
    const Transfer found = transfer(model, source, target, {.method = method});
    results.push_back(std::sqrt((found.model.predict(x) - truth).squaredNorm() / kTests));
    correlation = found.correlation;
  }
  results.push_back(correlation);
  return results;
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return 0.5 * (v[(v.size() - 1) / 2] + v[v.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  const auto seeds = static_cast<std::size_t>(argc > 1 ? std::atoi(argv[1]) : 20);
  const auto threads = static_cast<unsigned>(argc > 2 ? std::atoi(argv[2]) : 1);
  fmt::print("| target | rows |");
  for (const TransferMethod method : kMethods) fmt::print(" {} |", to_string(method));
  fmt::print(" weighted / better of target-only and shift-and-scale | correlation found |\n|---|");
  for (int i = 0; i < 9; ++i) fmt::print("---|");
  fmt::print("\n");
  for (const Pair& pair : pairs())
    for (const int size : kSizes) {
      std::vector<std::vector<double>> by_seed(seeds);
      parallel_for(seeds, threads, [&](std::size_t s) { by_seed[s] = run(pair, size, s + 1); });
      std::vector<double> medians;
      for (std::size_t k = 0; k < by_seed[0].size(); ++k) {
        std::vector<double> of_seeds;
        for (const auto& results : by_seed) of_seeds.push_back(results[k]);
        medians.push_back(median(of_seeds));
      }
      fmt::print("| {} | {} |", pair.name, size);
      for (std::size_t k = 0; k + 1 < medians.size(); ++k) fmt::print(" {:.2f} |", medians[k]);
      fmt::print(" {:.2f} | {:.2f} |\n", medians[5] / std::min(medians[1], medians[2]),
                 medians.back());
      std::fflush(stdout);
    }
}
