// How often screening finds what is there and what is not: the figures of
// docs/methods/screening.md.
//   repose_screening_rates [TRIALS]
// Each trial is one response of a definitive screening design with five repetitions; noise has the
// standard deviation 1, coefficients are in coded units.
#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/screening.hpp"

namespace {

using namespace repose;

constexpr int kRepetitions = 5;

struct Truth {
  std::string name;
  std::vector<double> main_effects;  ///< of the first factors; the others are inert
  double interaction = 0.0;          ///< of the first two
  double quadratic = 0.0;            ///< of the first
};

std::vector<Truth> truths(int factors) {
  const auto k = static_cast<std::size_t>(factors);
  return {{"noise", {}},
          {"three of 1.0", {1.0, 1.0, 1.0}},
          {"every other of 0.8", std::vector<double>((k + 1) / 2, 0.8)},
          {"all of 0.8", std::vector<double>(k, 0.8)},
          {"3, 2, 1.2, 0.9, 0.7", {3.0, 2.0, 1.2, 0.9, 0.7}},
          {"three of 1.2, x1 x2 1.2, x1^2 1.5", {1.2, 1.2, 1.2}, 1.2, 1.5}};
}

struct Method {
  std::string name;
  doe::ScreeningOptions options;
};

/// Backward from all main effects, and mixed steps over main and second-order effects.
std::vector<Method> methods() {
  std::vector<Method> all;
  for (const double leave : {0.01, 0.05, 0.1, 0.2, 0.999})
    all.push_back({fmt::format("backward, leave {}", leave),
                   {.p_leave = leave,
                    .candidates = doe::CandidateTerms::main_effects,
                    .direction = doe::StepDirection::backward}});
  for (const double leave : {0.01, 0.1})
    all.push_back({fmt::format("mixed, leave {}", leave), {.p_leave = leave}});
  return all;
}

Vector mean_response(const Matrix& x, const Truth& truth) {
  Vector mean = Vector::Zero(x.rows());
  for (std::size_t j = 0; j < truth.main_effects.size(); ++j)
    mean += truth.main_effects[j] * x.col(static_cast<Eigen::Index>(j));
  mean += truth.interaction * x.col(0).cwiseProduct(x.col(1));
  return mean + truth.quadratic * x.col(0).cwiseProduct(x.col(0));
}

struct Share {
  double hits = 0.0, of = 0.0;
  void count(double share) { hits += share, of += 1.0; }
  std::string text() const { return of > 0.0 ? fmt::format("{:.4f}", hits / of) : "-"; }
};

void print_rates(const Matrix& x, const Truth& truth, const Method& method, int trials) {
  RandomStream random(31);  // the same noise for every method
  std::vector<std::string> names;
  for (Eigen::Index j = 0; j < x.cols(); ++j) names.push_back(fmt::format("x{}", j + 1));
  Share found, found_by_vote, false_alarms, false_by_vote;
  for (int trial = 0; trial < trials; ++trial) {
    Matrix y(x.rows(), kRepetitions);
    for (double& value : y.reshaped()) value = random.normal();
    y.colwise() += mean_response(x, truth);
    const auto result = doe::screen(x, names, {"y"}, {y}, method.options);
    for (std::size_t j = 0; j < names.size(); ++j) {
      const bool active = j < truth.main_effects.size();
      const auto k = static_cast<Eigen::Index>(j);
      (active ? found : false_alarms).count(result.responses[0].count(k) / kRepetitions);
      (active ? found_by_vote : false_by_vote).count(result.selected[j] ? 1.0 : 0.0);
    }
  }
  fmt::print("{:>7} {:>4}  {:<34} {:<21} {:>7} {:>7}  {:>7} {:>7}\n", x.cols(), x.rows(),
             truth.name, method.name, false_alarms.text(), false_by_vote.text(), found.text(),
             found_by_vote.text());
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 400;
  if (trials < 1) {
    fmt::print(stderr, "repose_screening_rates: the number of trials must be at least 1\n");
    return 2;
  }
  fmt::print("{:>7} {:>4}  {:<34} {:<21} {:>15}  {:>15}\n", "factors", "runs", "main effects",
             "method", "found if inert", "found if active");
  fmt::print("{:>7} {:>4}  {:<34} {:<21} {:>7} {:>7}  {:>7} {:>7}\n", "", "", "", "", "each",
             "vote", "each", "vote");
  for (const int factors : {5, 7, 12, 15}) {
    const Matrix x = doe::definitive_screening_design(factors).coded;
    for (const auto& truth : truths(factors))
      for (const auto& method : methods()) print_rates(x, truth, method, trials);
  }
  return 0;
}
