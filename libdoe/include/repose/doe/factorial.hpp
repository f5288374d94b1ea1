// Two-level designs: full and fractional factorials, Plackett-Burman designs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// All combinations of levels, coded at equal distances from -1 to 1; the first factor varies
/// fastest. Throws InputError for a factor with fewer than 2 levels or more than a million runs.
Matrix full_factorial(const std::vector<int>& levels);

/// A product of factors: bit j is factor j.
using FactorProduct = std::uint64_t;

/// "ABE": one letter a factor, A to Z without I.
std::string product_name(FactorProduct product);
/// Throws InputError for a letter that is no factor, or that is given twice.
FactorProduct product_named(const std::string& name);

/// A regular two-level fraction: 2^base_factors runs of more factors.
struct FractionalFactorial {
  Matrix coded;  ///< 2^base_factors x factors, in {-1, 1}
  int base_factors = 0;
  /// Of each factor after the base factors: the product of base factors that its column is.
  std::vector<FactorProduct> generators;
  /// All products that are constant: 2^(generators) - 1, the shortest first, then in alphabetical
  /// order. Empty for a full factorial.
  std::vector<FactorProduct> defining_relation;
  /// Factors of the shortest of them; 0 for a full factorial. III mixes main effects with
  /// interactions of two factors, IV such interactions with each other, V neither.
  int resolution = 0;
  /// Whether no fraction of this size has less aberration: known for an exhaustive search.
  bool is_minimum_aberration = false;

  /// Number of products of each length, from 0 to the number of factors.
  std::vector<int> word_length_pattern() const;
};

/// A fraction with given generators, e.g. "E=ABCD" for the fifth factor: one for each factor after
/// the base factors, in any order. No generators give the full factorial. `factors` from 1 to 25.
/// Throws InputError for a generator that cannot be read, that repeats another one, or a number of
/// base factors above 16.
FractionalFactorial fractional_factorial(int factors, const std::vector<std::string>& generators);

/// The fraction with `runs` = 2^m runs that has minimum aberration [FriesHunter1980]: the fewest
/// words of length 3, among these of length 4, and so on. Searched for depth first; where that
/// takes more than `search_budget` steps (about a second), the best one met is returned and says
/// so. Exhaustive for 8 and 16 runs, for 32 runs of up to 16 factors, and for 64, 128 and 256 runs
/// of up to 12. Throws InputError unless runs are a power of two from 4 to 65536 and factors fit: m
/// <= factors < runs, at most 25.
FractionalFactorial minimum_aberration(int factors, int runs, std::int64_t search_budget = 4000000);

/// Sylvester's, Paley's [Paley1933] and other constructions from conference matrices: +-1, H H^T =
/// order I, first column +1. Orders 1, 2 and all multiples of 4 up to 100, and most up to 256.
/// Throws InputError for an order that cannot exist or is not built here.
Eigen::MatrixXi hadamard_matrix(int order);

enum class FoldOverRuns { none, appended };

/// runs x factors in {-1, 1} from a Hadamard matrix of the smallest order built > factors
/// [PlackettBurman1946]: main effects orthogonal to each other and to the mean, mixed with
/// interactions unless the mirror image of every run is appended. `factors` from 1 to 99. Throws
/// InputError otherwise.
Matrix plackett_burman(int factors, FoldOverRuns fold_over = FoldOverRuns::none);

}  // namespace repose::doe
