// Central composite and Box-Behnken designs.
#include "repose/doe/response_surface.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/doe/factorial.hpp"

namespace repose::doe {
namespace {

using Block = std::vector<int>;

int runs_of_resolution_five(int factors) {
  constexpr int kRuns[] = {4, 8, 16, 16, 32, 64, 64, 128, 128, 128};  // 2 to 11 factors
  return kRuns[factors - 2];
}

Matrix factorial_part(int factors) {
  const auto design = minimum_aberration(factors, runs_of_resolution_five(factors));
  REPOSE_ASSERT(design.resolution == 0 || design.resolution >= 5,
                fmt::format("{} factors, resolution {}", factors, design.resolution));
  return design.coded;
}

double alpha_of(const CentralCompositeOptions& options, double factorial_runs, double runs) {
  if (options.kind == CentralCompositeOptions::Kind::face_centred) return 1.0;
  return options.alpha == CentralCompositeOptions::Alpha::rotatable
             ? std::pow(factorial_runs, 0.25)
             : std::sqrt((std::sqrt(factorial_runs * runs) - factorial_runs) / 2.0);
}

std::vector<Block> cyclic(const Block& first, int factors) {
  std::vector<Block> blocks;
  for (int shift = 0; shift < factors; ++shift) {
    Block block;
    for (const int factor : first) block.push_back((factor - 1 + shift) % factors + 1);
    blocks.push_back(std::move(block));
  }
  return blocks;
}

std::vector<Block> all_pairs(int factors) {
  std::vector<Block> blocks;
  for (int i = 1; i <= factors; ++i)
    for (int j = i + 1; j <= factors; ++j) blocks.push_back({i, j});
  return blocks;
}

struct BoxBehnkenTable {
  std::vector<Block> blocks;  ///< factors from 1
  int centre_runs = 0;
};

/// [BoxBehnken1960], Table 4.
BoxBehnkenTable box_behnken_table(int factors) {
  switch (factors) {
    case 3:
    case 4:
      return {all_pairs(factors), 3};
    case 5:
      return {all_pairs(factors), 6};
    case 6:
      return {cyclic({1, 2, 4}, 6), 6};
    case 7:
      return {cyclic({1, 2, 4}, 7), 6};  // the lines of the plane of seven points
    case 9:  // the lines of the affine plane of nine points, one parallel class twice
      return {{{1, 4, 7},
               {2, 5, 8},
               {3, 6, 9},
               {1, 2, 3},
               {4, 5, 6},
               {7, 8, 9},
               {1, 5, 9},
               {3, 4, 8},
               {2, 6, 7},
               {1, 6, 8},
               {2, 4, 9},
               {3, 5, 7},
               {1, 4, 7},
               {2, 5, 8},
               {3, 6, 9}},
              10};
    case 10:
      return {{{2, 6, 7, 10},
               {1, 2, 5, 10},
               {2, 3, 7, 8},
               {2, 4, 6, 9},
               {1, 8, 9, 10},
               {3, 4, 5, 10},
               {1, 4, 7, 8},
               {3, 5, 7, 9},
               {1, 3, 6, 9},
               {4, 5, 6, 8}},
              10};
    case 11:
      return {cyclic({1, 2, 4, 7, 11}, 11), 12};
    case 12:
      return {cyclic({1, 2, 5, 7}, 12), 12};
    default:
      throw InputError(
          fmt::format("Box-Behnken design: {} factors; 3 to 7 and 9 to 12 are published", factors));
  }
}

/// All signs of the factors of a block; of five factors those whose product is +.
Matrix signs(int factors) {
  return factors == 5 ? fractional_factorial(5, {"E=ABCD"}).coded
                      : full_factorial(std::vector<int>(static_cast<std::size_t>(factors), 2));
}

}  // namespace

CentralComposite central_composite(int factors, const CentralCompositeOptions& options) {
  if (factors < 2 || factors > 11)
    throw InputError(fmt::format(
        "central composite design: {} factors; from 2 to 11 are possible, for more use d-optimal",
        factors));
  if (options.centre_runs < 1 || options.centre_runs > 1000)
    throw InputError(
        fmt::format("central composite design: {} centre runs; from 1 to 1000 are possible",
                    options.centre_runs));
  const Matrix factorial = factorial_part(factors);
  const Eigen::Index f = factorial.rows();
  CentralComposite design{Matrix::Zero(f + 2 * factors + options.centre_runs, factors),
                          static_cast<int>(f)};
  design.alpha =
      alpha_of(options, static_cast<double>(f), static_cast<double>(design.coded.rows()));
  const bool inscribed = options.kind == CentralCompositeOptions::Kind::inscribed;
  design.coded.topRows(f) = factorial / (inscribed ? design.alpha : 1.0);
  const double axial = inscribed ? 1.0 : design.alpha;
  for (int j = 0; j < factors; ++j) {
    design.coded(f + 2 * j, j) = -axial;
    design.coded(f + 2 * j + 1, j) = axial;
  }
  return design;
}

Matrix box_behnken(int factors, int centre_runs) {
  const BoxBehnkenTable table = box_behnken_table(factors);
  const int centres = centre_runs < 0 ? table.centre_runs : centre_runs;
  if (centres < 1 || centres > 1000)
    throw InputError(
        fmt::format("Box-Behnken design: {} centre runs; from 1 to 1000 are possible", centres));
  const Matrix of_block = signs(static_cast<int>(table.blocks.front().size()));
  Matrix coded = Matrix::Zero(
      of_block.rows() * static_cast<Eigen::Index>(table.blocks.size()) + centres, factors);
  for (std::size_t b = 0; b < table.blocks.size(); ++b)
    for (std::size_t j = 0; j < table.blocks[b].size(); ++j)
      coded.block(static_cast<Eigen::Index>(b) * of_block.rows(), table.blocks[b][j] - 1,
                  of_block.rows(), 1) = of_block.col(static_cast<Eigen::Index>(j));
  return coded;
}

}  // namespace repose::doe
