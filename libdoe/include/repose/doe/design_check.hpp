// What a design that came from elsewhere is worth: is it a definitive screening design, what is
// mixed up in it, what can it find, and which runs does it lack?
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {

/// What the estimate of a main effect carries of a second-order effect that the model leaves out.
struct Alias {
  int factor = 0;
  Term second_order;
  double coefficient = 0.0;
};

/// Runs and factors are numbered from 0. X holds the intercept and the main effects.
struct DesignCheck {
  int runs = 0;
  int factors = 0;
  std::vector<std::pair<int, int>> pairs;  ///< mirror images of each other, the lower run first
  /// Never at 0 while others are; what is said of levels below leaves them out.
  std::vector<int> two_level_factors;
  std::vector<int> centre_runs;       ///< all factors at 0
  std::vector<int> orphans;           ///< neither centre runs nor with a mirror image
  double column_sum_max = 0.0;        ///< largest |sum of a column|
  double gram_offdiagonal_max = 0.0;  ///< largest |X^T X| between two main effects
  Matrix correlation;                 ///< of the main effects, factors x factors; diagonal 1
  double correlation_max = 0.0;       ///< largest |correlation| of two main effects
  /// Entries of the alias matrix (X^T X)^-1 X^T Z, Z the second-order columns, in the rows of main
  /// effects that are not 0; the largest first. Empty if X has not full rank.
  std::vector<Alias> aliases;
  double alias_max = 0.0;  ///< largest |coefficient|; infinity if X has not full rank
  double alias_rms = 0.0;  ///< over all entries, zeros included; infinity likewise
  /// |X^T X|^(1/p) / runs with p = factors + 1: 1 for an orthogonal two-level design, 0 if X has
  /// not full rank.
  double d_efficiency = 0.0;
  /// Of each main effect's coefficient, over the standard deviation of one run; infinity if X has
  /// not full rank.
  Vector standard_error;
  /// For error in the fit of all main effects: runs - factors - 1.
  int residual_df = 0;
  /// For error before anything is selected in the two-stage analysis, from fake factors and
  /// repeated centre runs: pairs - factors + centre runs - 1; not below 0.
  int two_stage_df = 0;
  /// One sentence for each property of a definitive screening design that fails, runs counted
  /// from 1.
  std::vector<std::string> problems;

  bool is_definitive_screening() const { return problems.empty(); }
  /// Main effects are also uncorrelated, as in designs from conference matrices.
  bool is_orthogonal() const { return gram_offdiagonal_max == 0.0; }
};

/// Three levels, every run with its mirror image or a centre run, at least one centre run, at most
/// one factor of a run at the middle, main effects estimable and free of second-order effects
/// [JonesNachtsheim2011]. Levels within 1e-9 of each other count as equal. Throws InputError for an
/// empty matrix or values outside [-1, 1].
DesignCheck check_design(const Matrix& coded);

/// The runs a design lacks: the mirror image of each run that has none, in the order of those runs,
/// and a centre run if there is none (two mirrored ones if there are two-level factors). No rows if
/// nothing is missing. Appended, they separate main
/// effects from all second-order effects. Throws InputError as check_design().
Matrix missing_runs(const Matrix& coded);

}  // namespace repose::doe
