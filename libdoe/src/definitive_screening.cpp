// Definitive screening designs from conference matrices.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"

namespace repose::doe {
namespace {

constexpr int kFewestFactors = 3;
constexpr int kMostFactors = 100;

void check_options(int factors, const DefinitiveScreeningOptions& options) {
  if (factors < kFewestFactors || factors > kMostFactors)
    throw InputError(
        fmt::format("definitive screening design: {} factors; from {} to {} are possible", factors,
                    kFewestFactors, kMostFactors));
  if (options.fake_factors < 0 || options.fake_factors > 20)
    throw InputError(
        fmt::format("definitive screening design: {} fake factors; from 0 to 20 are possible",
                    options.fake_factors));
  if (options.centre_runs < 1 || options.centre_runs > 1000)
    throw InputError(
        fmt::format("definitive screening design: {} centre runs; from 1 to 1000 are possible",
                    options.centre_runs));
}

std::vector<int> shuffled_order(int runs, std::uint64_t seed) {
  std::vector<int> order(static_cast<std::size_t>(runs));
  std::iota(order.begin(), order.end(), 0);
  RandomStream(seed).shuffle(order);
  return order;
}

}  // namespace

Design definitive_screening_design(int factors, const DefinitiveScreeningOptions& options) {
  check_options(factors, options);
  // Order 4 cannot support the full quadratic model in any three factors: build from 6 at least.
  const int n = conference_order(std::max(6, factors + factors % 2 + options.fake_factors));
  const Matrix half = conference_matrix(n).leftCols(factors).cast<double>();
  const int runs = 2 * n + options.centre_runs;

  Design design{Matrix::Zero(runs, factors), std::vector<int>(static_cast<std::size_t>(runs), 0)};
  for (int pair = 0; pair < n; ++pair)
    for (const int mirror : {0, 1}) {
      const int run = 2 * pair + mirror;
      design.coded.row(run) = mirror == 0 ? half.row(pair) : Matrix(-half.row(pair));
      design.pair_id[static_cast<std::size_t>(run)] = pair + 1;
    }
  design.coded.array() += 0.0;  // no negative zeros
  if (options.run_order == RunOrder::structured) return design;

  const std::vector<int> order = shuffled_order(runs, options.seed);
  Design shuffled = design;
  for (int run = 0; run < runs; ++run) {
    const int from = order[static_cast<std::size_t>(run)];
    shuffled.coded.row(run) = design.coded.row(from);
    shuffled.pair_id[static_cast<std::size_t>(run)] =
        design.pair_id[static_cast<std::size_t>(from)];
  }
  return shuffled;
}

}  // namespace repose::doe
