// Conference matrices and definitive screening designs.
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
  /// What stands in the columns of two-level factors where others are at the middle.
  enum class TwoLevelRule {
    /// Opposite signs in the two runs of a pair, chosen to keep the columns' inner products small:
    /// main effects stay orthogonal to all second-order effects, but not quite to each other.
    fold_over,
    /// + in both runs of a pair: main effects stay orthogonal to each other, but not quite to
    /// interactions. At most 4 two-level factors.
    orthogonal,
  };
  enum class BlockCentres {
    each_block,   ///< every block has centre runs: all quadratic effects can be estimated
    first_block,  ///< only block 1 has
  };
  /// Columns built and dropped again; each gives one degree of freedom for error (two: "four extra
  /// runs"). >= 0 [JonesNachtsheim2017].
  int fake_factors = 2;
  /// Sets of centre runs in a block that has some, >= 1; more than one gives pure error. A set is
  /// one run with every factor at the middle; with two-level factors, which have none, it is two
  /// mirrored runs, under TwoLevelRule::orthogonal four.
  int centre_runs = 1;
  /// Factors that have two levels only, -1 and 1, numbered from 0 [JonesNachtsheim2013].
  std::vector<int> two_level_factors = {};
  TwoLevelRule two_level_rule = TwoLevelRule::fold_over;
  /// From 1 to the number of factors; both runs of a pair lie in one block, so that blocks are
  /// orthogonal to main effects. More than one needs TwoLevelRule::fold_over.
  int blocks = 1;
  BlockCentres block_centres = BlockCentres::each_block;
  /// Randomised means within blocks.
  RunOrder run_order = RunOrder::randomised;
  /// Of the random order; unused if structured.
  std::uint64_t seed = 1;
};

/// Runs in coded units, block after block.
struct Design {
  Matrix coded;  ///< runs x factors, in {-1, 0, 1}
  std::vector<int>
      pair_id;  ///< of each run: 1, 2, ... for the two runs of a fold-over pair, 0 = centre
  std::vector<int> block;  ///< of each run: 1, 2, ...
};

/// Rows of C, rows of -C and centre runs, with only the first `factors` columns kept
/// [XiaoLinBai2012]. The order of C is the smallest one built >= max(6, factors rounded up to even
/// + fake factors), so there are 2 order runs and the centre runs. `factors` from 3 to 100, at
/// least one of them with three levels. Main effects are orthogonal to each other and to every
/// second-order effect, but for what TwoLevelRule says. Throws InputError for options out of range.
Design definitive_screening_design(int factors, const DefinitiveScreeningOptions& options = {});

}  // namespace repose::doe
