// Stepwise regression by p-value thresholds.
#include "repose/doe/stepwise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "sweep.hpp"

namespace repose::doe {
namespace {

using Action = StepwiseStep::Action;
using Termination = StepwiseResult::Termination;

bool has(const std::vector<Term>& terms, const Term& term) {
  return std::find(terms.begin(), terms.end(), term) != terms.end();
}

void check_input(const Matrix& coded, const Vector& y, const std::vector<std::string>& factors,
                 const std::vector<Term>& candidates, const StepwiseOptions& options) {
  if (static_cast<Eigen::Index>(factors.size()) != coded.cols() || coded.rows() != y.size())
    throw InputError(
        fmt::format("stepwise regression: a design of {} x {} for {} factor names and {} "
                    "responses",
                    coded.rows(), coded.cols(), factors.size(), y.size()));
  if (!coded.allFinite() || !y.allFinite())
    throw InputError("stepwise regression: a level or a response is not finite");
  if (candidates.empty()) throw InputError("stepwise regression: there are no candidate terms");
  if (y.size() < 3)
    throw InputError(fmt::format("stepwise regression: {} runs; at least 3 are needed", y.size()));
  for (const double p : {options.p_enter, options.p_leave})
    if (!(p > 0.0 && p < 1.0))
      throw InputError(fmt::format("stepwise regression: threshold {} is not in (0, 1)", p));
}

/// The state of a selection: data, the model so far, and the tests of changing it.
class Selection {
 public:
  Selection(const Matrix& coded, const Vector& y, const std::vector<std::string>& factors,
            const std::vector<Term>& candidates, const StepwiseOptions& options)
      : coded_(coded),
        y_(y),
        factors_(factors),
        candidates_(candidates),
        rule_(options.rule),
        p_enter_(options.p_enter),
        p_leave_(std::max(options.p_leave, options.p_enter)) {}

  StepwiseResult run(StepDirection direction) {
    StepwiseResult result;
    if (direction == StepDirection::backward) terms_ = candidates_;
    std::set<std::vector<Term>> visited{sorted_terms()};
    while (true) {
      std::optional<StepwiseStep> step;
      if (direction != StepDirection::forward) step = best_leaving();
      if (!step && direction != StepDirection::backward) {
        if (sweep_of_model().is_exact()) {
          result.termination = Termination::exact_fit;
          break;
        }
        step = best_entering();
      }
      if (!step) break;
      apply(*step);
      result.path.push_back(std::move(*step));
      if (!visited.insert(sorted_terms()).second) {
        result.termination = Termination::cycle;
        break;
      }
    }
    result.terms = terms_;
    result.fit = fit_model();
    result.anova = analysis_of_variance(result.fit);
    return result;
  }

 private:
  LeastSquaresFit fit_model() const {
    return fit_least_squares(model_matrix(coded_, terms_), y_, column_names(terms_, factors_));
  }

  Sweep sweep_of_model() const {
    Sweep sweep(y_);
    sweep.append(Vector::Ones(y_.size()));
    for (const Term& term : terms_) sweep.append(term_column(coded_, term));
    return sweep;
  }

  std::vector<Term> sorted_terms() const {
    std::vector<Term> sorted = terms_;
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }

  std::vector<Term> absent_precedents(const Term& term) const {
    std::vector<Term> absent;
    for (const Term& precedent : precedents(term))
      if (!has(terms_, precedent)) absent.push_back(precedent);
    return absent;
  }

  /// The test of entering `term` into the model of `sweep`; nothing if it cannot enter.
  std::optional<StepwiseStep> entering(const Term& term, Sweep sweep) const {
    StepwiseStep step{Action::enter, term, {}, 0.0};
    if (rule_ != HierarchyRule::none) step.entered_with = absent_precedents(term);
    if (rule_ == HierarchyRule::restrict && !step.entered_with.empty()) return std::nullopt;

    const double ss_before = sweep.residual_ss();
    for (const Term& precedent : step.entered_with)
      if (!sweep.append(term_column(coded_, precedent))) return std::nullopt;
    const double ss_with_precedents = sweep.residual_ss();
    if (!sweep.append(term_column(coded_, term)) || sweep.residual_df() < 1) return std::nullopt;

    const double mean_square = sweep.residual_ss() / sweep.residual_df();
    const double joint_df = static_cast<double>(step.entered_with.size() + 1);
    const double joint_p = f_upper_tail((ss_before - sweep.residual_ss()) / joint_df / mean_square,
                                        joint_df, sweep.residual_df());
    const double own_p = f_upper_tail((ss_with_precedents - sweep.residual_ss()) / mean_square, 1.0,
                                      sweep.residual_df());
    step.p = rule_ == HierarchyRule::combine ? std::max(joint_p, own_p) : joint_p;
    return step;
  }

  std::optional<StepwiseStep> best_entering() const {
    std::optional<StepwiseStep> best;
    const Sweep sweep = sweep_of_model();
    for (const Term& candidate : candidates_) {
      if (has(terms_, candidate)) continue;
      std::optional<StepwiseStep> step = entering(candidate, sweep);
      if (step && step->p <= p_enter_ && (!best || step->p < best->p)) best = std::move(step);
    }
    return best;
  }

  bool carries_others(const Term& term) const {
    return rule_ != HierarchyRule::none &&
           std::any_of(terms_.begin(), terms_.end(),
                       [&](const Term& other) { return has(precedents(other), term); });
  }

  std::optional<StepwiseStep> best_leaving() const {
    if (terms_.empty()) return std::nullopt;
    std::optional<StepwiseStep> best;
    const LeastSquaresFit fit = fit_model();
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      const double p = fit.p(1 + static_cast<Eigen::Index>(j));
      if (p > p_leave_ && !carries_others(terms_[j]) && (!best || p > best->p))
        best = StepwiseStep{Action::leave, terms_[j], {}, p};
    }
    return best;
  }

  void apply(const StepwiseStep& step) {
    if (step.action == Action::leave) {
      std::erase(terms_, step.term);
      return;
    }
    terms_.insert(terms_.end(), step.entered_with.begin(), step.entered_with.end());
    terms_.push_back(step.term);
  }

  const Matrix& coded_;
  const Vector& y_;
  const std::vector<std::string>& factors_;
  const std::vector<Term>& candidates_;
  HierarchyRule rule_;
  double p_enter_, p_leave_;
  std::vector<Term> terms_;
};

}  // namespace

StepwiseResult stepwise_regression(const Matrix& coded, const Vector& y,
                                   const std::vector<std::string>& factors,
                                   const std::vector<Term>& candidates,
                                   const StepwiseOptions& options) {
  check_input(coded, y, factors, candidates, options);
  return Selection(coded, y, factors, candidates, options).run(options.direction);
}

}  // namespace repose::doe
