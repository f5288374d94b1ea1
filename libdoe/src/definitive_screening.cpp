// Definitive screening designs from conference matrices.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"

namespace repose::doe {
namespace {

using TwoLevelRule = DefinitiveScreeningOptions::TwoLevelRule;
using BlockCentres = DefinitiveScreeningOptions::BlockCentres;

constexpr int kFewestFactors = 3;
constexpr int kMostFactors = 100;

void check_count(const char* what, int value, int least, int most) {
  if (value < least || value > most)
    throw InputError(fmt::format("definitive screening design: {} {}; from {} to {} are possible",
                                 value, what, least, most));
}

void check_two_level(int factors, const DefinitiveScreeningOptions& options) {
  const auto& two_level = options.two_level_factors;
  const std::set<int> different(two_level.begin(), two_level.end());
  if (different.size() != two_level.size() ||
      (!different.empty() && (*different.begin() < 0 || *different.rbegin() >= factors)))
    throw InputError(
        fmt::format("definitive screening design: two-level factors must be different numbers from "
                    "0 to {}",
                    factors - 1));
  if (static_cast<int>(two_level.size()) == factors)
    throw InputError(
        "definitive screening design: every factor has two levels only; at least one must have "
        "three, or use a factorial design");
  if (options.two_level_rule != TwoLevelRule::orthogonal || two_level.empty()) return;
  if (two_level.size() > 4)
    throw InputError(
        fmt::format("definitive screening design: {} two-level factors; at most 4 can be kept "
                    "orthogonal to each other, use the fold-over rule",
                    two_level.size()));
  if (options.blocks > 1)
    throw InputError(
        "definitive screening design: the orthogonal rule leaves two-level factors not orthogonal "
        "to blocks; use one block or the fold-over rule");
}

void check_options(int factors, const DefinitiveScreeningOptions& options) {
  check_count("factors", factors, kFewestFactors, kMostFactors);
  check_count("fake factors", options.fake_factors, 0, 20);
  check_count("centre runs", options.centre_runs, 1, 1000);
  check_count("blocks", options.blocks, 1, factors);
  check_two_level(factors, options);
}

struct Halves {
  Matrix one, other;  ///< row i of the two are the runs of pair i
  Matrix centre;      ///< one set of centre runs
};

/// Signs for a fold-over design with two-level factors: s_j where pair j has its zero, z_j in the
/// centre runs. Inner products of columns j, l are then 2 (s_j C_jl + s_l C_lj + z_j z_l), which
/// one sign at a time is turned to make smaller.
struct Signs {
  std::vector<int> zero, centre;
};

Signs small_products(const Matrix& c, const std::vector<int>& two_level) {
  const std::size_t m = two_level.size();
  Signs signs{std::vector<int>(m, 1), std::vector<int>(m, 1)};
  const auto cost_of = [&](std::size_t j) {
    double cost = 0.0;
    for (std::size_t l = 0; l < m; ++l) {
      if (l == j) continue;
      const double product = signs.zero[j] * c(two_level[j], two_level[l]) +
                             signs.zero[l] * c(two_level[l], two_level[j]) +
                             signs.centre[j] * signs.centre[l];
      cost += product * product;
    }
    return cost;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t j = 0; j < m; ++j)
      for (auto* kind : {&signs.zero, &signs.centre}) {
        const double before = cost_of(j);
        (*kind)[j] *= -1;
        if (cost_of(j) < before)
          changed = true;
        else
          (*kind)[j] *= -1;
      }
  }
  return signs;
}

Halves with_two_levels(const Matrix& c, const DefinitiveScreeningOptions& options) {
  const auto& two_level = options.two_level_factors;
  Halves halves{c, -c, Matrix::Zero(1, c.cols())};
  if (two_level.empty()) return halves;
  const bool orthogonal = options.two_level_rule == TwoLevelRule::orthogonal;
  const Signs signs = small_products(c, two_level);
  // Columns with one + and three - are orthogonal to each other and add up to -2, the two + above
  // to +2.
  halves.centre = Matrix::Zero(orthogonal ? 4 : 2, c.cols());
  for (std::size_t j = 0; j < two_level.size(); ++j) {
    const int column = two_level[j];
    const int sign = orthogonal ? 1 : signs.zero[j];
    halves.one(column, column) = sign;
    halves.other(column, column) = orthogonal ? 1 : -sign;
    for (int run = 0; run < halves.centre.rows(); ++run)
      halves.centre(run, column) = orthogonal ? (run == static_cast<int>(j) ? 1 : -1)
                                              : (run == 0 ? -1 : 1) * signs.centre[j];
  }
  return halves;
}

/// The runs of one block in structured order: its pairs, then its centre runs.
void append_block(const Halves& halves, int block, const DefinitiveScreeningOptions& options,
                  Design& design, Eigen::Index& run) {
  const auto append = [&](const auto& row, int pair_id) {
    design.coded.row(run++) = row;
    design.pair_id.push_back(pair_id);
    design.block.push_back(block + 1);
  };
  for (int pair = block; pair < halves.one.rows(); pair += options.blocks) {
    append(halves.one.row(pair), pair + 1);
    append(halves.other.row(pair), pair + 1);
  }
  if (block > 0 && options.block_centres == BlockCentres::first_block) return;
  for (int set = 0; set < options.centre_runs; ++set)
    for (const auto& row : halves.centre.rowwise()) append(row, 0);
}

/// Shuffles the runs of each block.
Design randomised(const Design& design, std::uint64_t seed) {
  RandomStream random(seed);
  Design shuffled = design;
  const std::size_t runs = design.block.size();
  for (std::size_t begin = 0, end = 0; begin < runs; begin = end) {
    while (end < runs && design.block[end] == design.block[begin]) ++end;
    std::vector<std::size_t> order(end - begin);
    std::iota(order.begin(), order.end(), begin);
    random.shuffle(order);
    for (std::size_t i = 0; i < order.size(); ++i) {
      shuffled.coded.row(static_cast<Eigen::Index>(begin + i)) =
          design.coded.row(static_cast<Eigen::Index>(order[i]));
      shuffled.pair_id[begin + i] = design.pair_id[order[i]];
    }
  }
  return shuffled;
}

}  // namespace

Design definitive_screening_design(int factors, const DefinitiveScreeningOptions& options) {
  check_options(factors, options);
  // Order 4 cannot support the full quadratic model in any three factors: build from 6 at least.
  const int n = conference_order(std::max(6, factors + factors % 2 + options.fake_factors));
  const Halves halves =
      with_two_levels(conference_matrix(n).leftCols(factors).cast<double>(), options);
  const auto centre_blocks = options.block_centres == BlockCentres::each_block ? options.blocks : 1;

  Design design{
      Matrix(2 * n + centre_blocks * options.centre_runs * halves.centre.rows(), factors), {}, {}};
  Eigen::Index run = 0;
  for (int block = 0; block < options.blocks; ++block)
    append_block(halves, block, options, design, run);
  design.coded.array() += 0.0;  // no negative zeros
  return options.run_order == RunOrder::structured ? design : randomised(design, options.seed);
}

}  // namespace repose::doe
