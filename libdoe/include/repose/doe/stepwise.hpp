// Stepwise regression by p values or information criteria, with rules for terms made of others.
#pragma once

#include <string>
#include <vector>

#include "repose/doe/anova.hpp"
#include "repose/doe/least_squares.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {

enum class StepDirection { forward, backward, mixed };

/// How an interaction or quadratic is treated while main effects it is made of are not in the
/// model.
enum class HierarchyRule {
  combine,  ///< enters with them, p = max(joint F test, F test of the term after them); JMP >= 14
  combine_joint,  ///< enters with them, p = joint F test; JMP <= 13
  restrict,       ///< may not enter before them
  none,           ///< enters alone
};

/// When to stop, and by what to choose the next step.
enum class StoppingRule {
  p_value,  ///< the smallest p enters, the largest leaves, until the thresholds stop it
  /// The step with the smallest criterion. Forward and backward go on to the end of their path and
  /// return its best model; mixed stops at the first model that no step improves.
  aicc,
  bic,
};

struct StepwiseOptions {
  StoppingRule stop = StoppingRule::p_value;
  StepDirection direction = StepDirection::mixed;
  HierarchyRule rule = HierarchyRule::combine;
  double p_enter = 0.01;  ///< p_value only: a candidate enters if its p <= p_enter; in (0, 1)
  double p_leave =
      0.01;  ///< p_value only: a term leaves if its p > p_leave; raised to p_enter if below it
};

struct StepwiseStep {
  enum class Action { enter, leave };
  Action action = Action::enter;
  Term term;
  std::vector<Term> entered_with;  ///< absent precedents that a combined step brought in
  double p = 0.0;                  ///< of the F test of this step
  double aicc = 0.0;               ///< of the model after it
  double bic = 0.0;
};

struct StepwiseResult {
  enum class Termination {
    no_candidate,  ///< nothing more may enter or leave
    exact_fit,     ///< the residual is rounding; p values say nothing any more
    cycle,         ///< the model had been there before
  };
  std::vector<StepwiseStep> path;
  std::size_t chosen = 0;   ///< the final model is that after so many steps of the path
  std::vector<Term> terms;  ///< of the final model, in the order of entering
  LeastSquaresFit fit;      ///< intercept first, blocks last
  std::vector<AnovaRow> anova;
  Termination termination = Termination::no_candidate;
};

/// Selects among `candidates`; the intercept and, if `blocks` numbers the block of each run, the
/// blocks are always in. A test of entering uses the residual
/// mean square of the model with the candidate. Except under `none`, a term on which another one in
/// the model rests cannot leave. Backward starts from all candidates, which must then be estimable.
/// `coded` is runs x factors, `y` has one value a run, all finite. Throws InputError otherwise.
StepwiseResult stepwise_regression(const Matrix& coded, const Vector& y,
                                   const std::vector<std::string>& factors,
                                   const std::vector<Term>& candidates,
                                   const StepwiseOptions& options = {},
                                   const std::vector<int>& blocks = {});

}  // namespace repose::doe
