// Points that fill the unit cube: Latin hypercubes, quasi-random sequences, and new points in the
// gaps between given ones.
#pragma once

#include <cstdint>
#include <functional>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// Whether a point of the unit cube may be used; empty: every point. Must not depend on anything
/// else, so that a seed gives the same points.
using PointFilter = std::function<bool(const Vector& unit)>;

/// The points of `space` that obey its constraints; empty if it has none. Refers to `space`.
PointFilter constraint_filter(const ParameterSpace& space);

struct LatinHypercubeOptions {
  enum class Criterion {
    plain,        ///< random
    maximin,      ///< swaps that raise the smallest distance, by phi_20 of [MorrisMitchell1995]
    correlation,  ///< swaps that lower the sum of squared column correlations
  };
  Criterion criterion = Criterion::maximin;
  /// Swaps tried; >= 0. One costs O(points) for maximin, O(dimensions) for correlation.
  int iterations = 20000;
  std::uint64_t seed = 1;
  PointFilter allowed = {};
};

/// points x dimensions in (0,1): every column has exactly one value in each of the `points` equal
/// cells. The optimised criteria start from the plain hypercube of the same seed and are never
/// worse than it by their own measure. If a filter refuses any of its points, the allowed ones of a
/// plain hypercube of M > points cells, at most one in each cell of a column; for maximin, up to
/// 1000 points, of one with twice as many allowed ones, the closest left out. Throws InputError if
/// points or dimensions < 1 or hardly any point is allowed.
Matrix latin_hypercube(int points, int dimensions, const LatinHypercubeOptions& options = {});

struct SobolOptions {
  enum class Scrambling {
    none,           ///< the sequence itself; its first point is 0
    digital_shift,  ///< one random shift of all binary digits for each dimension
    owen,           ///< nested uniform scrambling [Owen1995]: each digit by all before it
  };
  Scrambling scrambling = Scrambling::owen;
  std::uint64_t seed = 1;
  PointFilter allowed = {};
};

/// The first points of Sobol's sequence with the direction numbers of [JoeKuo2008], points x
/// dimensions in [0,1), scrambled ones in (0,1). Any 2^m first points have exactly one value in
/// each of 2^m equal cells of each column, and are a (0, m, 2)-net in the first two. Scrambling
/// keeps that and makes each point uniform. Cost with Owen's: about 2 us a coordinate. With a
/// filter, the first points that are allowed. Throws InputError if points < 0, if dimensions are
/// not in 1 to 3667, or if hardly any point is allowed.
Matrix sobol_points(Eigen::Index points, Eigen::Index dimensions, const SobolOptions& options = {});

struct HaltonOptions {
  enum class Scrambling {
    none,      ///< radical inverses of 1, 2, ... in the first primes [Halton1960]
    permuted,  ///< from 0 on, each digit by a random permutation [Owen2017]
  };
  Scrambling scrambling = Scrambling::permuted;
  std::uint64_t seed = 1;
  PointFilter allowed = {};
};

/// points x dimensions in [0,1). The first b^m points have exactly one value in each of b^m equal
/// cells of the column with base b. Unscrambled, columns of large bases are correlated: above 6
/// dimensions use `permuted`. Throws InputError if points < 0, if dimensions are not in 1 to 1000,
/// or if hardly any point is allowed.
Matrix halton_points(Eigen::Index points, Eigen::Index dimensions,
                     const HaltonOptions& options = {});

struct FillingOptions {
  /// Points tried for each new one; >= 1.
  int candidates = 1000;
  std::uint64_t seed = 1;
  PointFilter allowed = {};
};

/// `points` new rows beside those of `existing` (rows in the unit cube), one after the other: of
/// the candidates the one farthest from its nearest neighbour. If `existing` is nearly a Latin
/// hypercube (each column has points in three quarters of existing.rows() cells) or empty,
/// candidates take their coordinates from cells, of existing.rows() + points in each column, that
/// hold no point yet; where no such candidate is allowed, and for other tables, from anywhere.
/// Throws InputError if existing leaves the unit cube or has no columns, if points or candidates <
/// 1, or if hardly any point is allowed.
Matrix filling_points(const Matrix& existing, int points, const FillingOptions& options = {});

}  // namespace repose::doe
