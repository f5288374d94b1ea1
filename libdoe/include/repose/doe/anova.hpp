// Analysis of variance of a linear model: what each term explains, by the three usual orders of
// asking.
#pragma once

#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {

/// Which other terms are in the model when a term is asked what it explains. The three agree where
/// terms are orthogonal.
enum class SumsOfSquares {
  type_one,    ///< those before it: the sums add up to that of the model, the order matters
  type_two,    ///< all that do not contain it: x1*x2 and x1^2 contain x1
  type_three,  ///< all others; for a term of one column F = t^2
};

/// Columns of a model matrix that stand and fall together, such as the levels of one category.
struct ColumnGroup {
  std::string name;
  std::vector<int> columns;
  /// Groups, by their position in the list, that contain this one; used by type II only.
  std::vector<int> contained_in = {};
};

struct AnovaRow {
  std::string term;
  double sum_of_squares = 0.0;
  int df = 0;
  double f = 0.0;  ///< against the residual mean square of the whole model; NaN without one
  double p = 0.0;
};

/// `x` is n x p, y has n values; columns that no group names (an intercept, blocks) are always in
/// the model. Sums of squares come from the rotated response, not from differences. Throws
/// InputError if sizes do not fit, a group is empty, names a column or group that does not exist or
/// one that another names too, and where columns are linearly dependent.
std::vector<AnovaRow> analysis_of_variance(const Matrix& x, const Vector& y,
                                           const std::vector<ColumnGroup>& groups,
                                           SumsOfSquares type = SumsOfSquares::type_three);

/// Of model_matrix(coded, terms, blocks): the terms in the order given, after the blocks.
std::vector<AnovaRow> analysis_of_variance(const Matrix& coded, const Vector& y,
                                           const std::vector<std::string>& factors,
                                           const std::vector<Term>& terms,
                                           SumsOfSquares type = SumsOfSquares::type_three,
                                           const std::vector<int>& blocks = {});

}  // namespace repose::doe
