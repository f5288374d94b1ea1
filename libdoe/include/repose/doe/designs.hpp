// Designs of experiments: conference matrices, definitive screening designs, Latin hypercubes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// A conference matrix C: zero diagonal, +-1 elsewhere, C C^T = C^T C = (order-1) I.
/// Built by Paley's construction where order-1 is a prime power [Paley1933], by doubling a skew
/// one, from four circulants (36 [Goethals1970], 52) and from blocks (46) [Mathon1978]: every order
/// from 4 to 64 that exists, and most up to 128. Throws InputError for an order that is odd, that
/// cannot exist (22, 34, 58: order-1 is no sum of two squares) or that is not built here; the
/// message names the next order that is.
Eigen::MatrixXi conference_matrix(int order);

/// The smallest order >= `at_least` that conference_matrix() builds. Throws InputError above 128.
int conference_order(int at_least);

enum class RunOrder { structured, randomised };

struct DefinitiveScreeningOptions {
  /// Columns built and dropped again; each gives one degree of freedom for error (two: "four extra
  /// runs"). >= 0 [JonesNachtsheim2017].
  int fake_factors = 2;
  /// >= 1; more than one gives pure error.
  int centre_runs = 1;
  RunOrder run_order = RunOrder::randomised;
  /// Of the random order; unused if structured.
  std::uint64_t seed = 1;
};

/// Runs in coded units.
struct Design {
  Matrix coded;  ///< runs x factors, in {-1, 0, 1}
  std::vector<int>
      pair_id;  ///< of each run: 1, 2, ... for the two runs of a fold-over pair, 0 = centre
};

/// Rows of C, rows of -C and centre runs, with only the first `factors` columns kept
/// [XiaoLinBai2012]. The order of C is the smallest one built >= max(6, factors rounded up to even
/// + fake factors), so there are 2 order + centre_runs runs. `factors` from 3 to 100. Main effects
/// are orthogonal to each other and to every second-order effect. Throws InputError for options out
/// of range.
Design definitive_screening_design(int factors, const DefinitiveScreeningOptions& options = {});

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
};

/// points x dimensions in (0,1): every column has exactly one value in each of the `points` equal
/// cells. The optimised criteria start from the plain hypercube of the same seed and are never
/// worse than it by their own measure. Throws InputError if points or dimensions < 1.
Matrix latin_hypercube(int points, int dimensions, const LatinHypercubeOptions& options = {});

}  // namespace repose::doe
