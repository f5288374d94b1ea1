// Stepwise regression.
#include "repose/doe/stepwise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "repose/doe/regression_diagnostics.hpp"
#include "sweep.hpp"

namespace repose::doe {
namespace {

using Action = StepwiseStep::Action;
using Termination = StepwiseResult::Termination;

bool has(const std::vector<Term>& terms, const Term& term) {
  return std::find(terms.begin(), terms.end(), term) != terms.end();
}

void check_input(const Matrix& coded, const Vector& y, const std::vector<std::string>& factors,
                 const std::vector<Term>& candidates, const StepwiseOptions& options,
                 const std::vector<int>& blocks) {
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
  const Eigen::Index columns = model_matrix(coded, candidates, blocks).cols();
  if (options.direction == StepDirection::backward && y.size() <= columns)
    throw InputError(fmt::format(
        "stepwise regression: backward steps begin with all {} columns, and {} runs leave "
        "no residual to test them with; go forward, or take fewer candidate terms",
        columns, y.size()));
  for (const double p : {options.p_enter, options.p_leave})
    if (!(p > 0.0 && p < 1.0))
      throw InputError(fmt::format("stepwise regression: threshold {} is not in (0, 1)", p));
}

/// The state of a selection: data, the model so far, and the steps that may change it.
class Selection {
 public:
  Selection(const Matrix& coded, const Vector& y, const std::vector<std::string>& factors,
            const std::vector<Term>& candidates, const StepwiseOptions& options,
            const std::vector<int>& blocks)
      : coded_(coded),
        y_(y),
        factors_(factors),
        candidates_(candidates),
        blocks_(blocks),
        options_(options),
        p_leave_(std::max(options.p_leave, options.p_enter)) {
    if (options.direction == StepDirection::backward) terms_ = candidates;
  }

  StepwiseResult run() {
    StepwiseResult result;
    if (options_.stop == StoppingRule::p_value)
      follow_p_values(result);
    else
      follow_criterion(result);
    result.terms = terms_;
    result.fit = fit_model();
    result.anova =
        analysis_of_variance(coded_, y_, factors_, terms_, SumsOfSquares::type_three, blocks_);
    return result;
  }

 private:
  void follow_p_values(StepwiseResult& result) {
    std::set<std::vector<Term>> visited{sorted_terms()};
    while (true) {
      std::optional<StepwiseStep> step;
      const auto smaller = [](const StepwiseStep& a, const StepwiseStep& b) { return a.p < b.p; };
      if (options_.direction == StepDirection::backward && sweep_of_model().is_exact()) {
        strip_exact_model(result);
        break;
      }
      if (options_.direction != StepDirection::forward)
        step = first(leaving_steps(), [&](const auto& a, const auto& b) { return smaller(b, a); });
      if (step && !(step->p > p_leave_)) step.reset();
      if (!step && options_.direction != StepDirection::backward) {
        if (sweep_of_model().is_exact()) {
          result.termination = Termination::exact_fit;
          break;
        }
        step = first(entering_steps(), smaller);
        if (step && !(step->p <= options_.p_enter)) step.reset();
      }
      if (!step) break;
      apply(*step);
      result.path.push_back(std::move(*step));
      if (!visited.insert(sorted_terms()).second) {
        result.termination = Termination::cycle;
        break;
      }
    }
    result.chosen = result.path.size();
  }

  void follow_criterion(StepwiseResult& result) {
    const bool mixed = options_.direction == StepDirection::mixed;
    std::vector<Term> best_terms = terms_;
    double best = criterion_of_model();
    while (true) {
      if (sweep_of_model().is_exact()) {
        strip_exact_model(result);
        best_terms = terms_;
        result.chosen = result.path.size();
        break;
      }
      std::vector<StepwiseStep> steps;
      if (options_.direction != StepDirection::backward) steps = entering_steps();
      if (options_.direction != StepDirection::forward)
        for (StepwiseStep& step : leaving_steps()) steps.push_back(std::move(step));
      std::optional<StepwiseStep> step =
          first(std::move(steps), [&](const StepwiseStep& a, const StepwiseStep& b) {
            return std::pair(criterion(a), a.bic) < std::pair(criterion(b), b.bic);
          });
      if (!step || (mixed && !(criterion(*step) < best))) break;
      apply(*step);
      const double value = criterion(*step);
      result.path.push_back(std::move(*step));
      if (!(value < best)) continue;
      best = value;
      best_terms = terms_;
      result.chosen = result.path.size();
    }
    terms_ = best_terms;
  }

  /// The residual is rounding and p values mean nothing: takes out every term without which it
  /// still is.
  void strip_exact_model(StepwiseResult& result) {
    result.termination = Termination::exact_fit;
    for (bool found = true; found;) {
      found = false;
      for (const Term& term : std::vector<Term>(terms_.rbegin(), terms_.rend())) {
        if (carries_others(term)) continue;
        const std::vector<Term> before = terms_;
        std::erase(terms_, term);
        const Sweep sweep = sweep_of_model();
        if (!sweep.is_exact()) {
          terms_ = before;
          continue;
        }
        StepwiseStep step{.action = Action::leave, .term = term, .p = 1.0};
        set_criteria(step, sweep.residual_ss(), sweep.residual_df());
        result.path.push_back(std::move(step));
        found = true;
      }
    }
  }

  double criterion(const StepwiseStep& step) const {
    return options_.stop == StoppingRule::bic ? step.bic : step.aicc;
  }

  double criterion_of_model() const {
    StepwiseStep here;
    const Sweep sweep = sweep_of_model();
    set_criteria(here, sweep.residual_ss(), sweep.residual_df());
    return criterion(here);
  }

  void set_criteria(StepwiseStep& step, double residual_ss, int residual_df) const {
    const int n = static_cast<int>(y_.size());
    const InformationCriteria criteria =
        information_criteria(std::max(0.0, residual_ss), n, n - residual_df);
    step.aicc = criteria.aicc;
    step.bic = criteria.bic;
  }

  LeastSquaresFit fit_model() const {
    return fit_least_squares(model_matrix(coded_, terms_, blocks_), y_,
                             column_names(terms_, factors_, blocks_));
  }

  Sweep sweep_of_model() const {
    Sweep sweep(y_);
    sweep.append_all(model_matrix(coded_, terms_, blocks_));
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

  /// The step that enters `term` into the model; nothing if it cannot enter.
  std::optional<StepwiseStep> entering(const Term& term, const Sweep& model) const {
    StepwiseStep step{.action = Action::enter, .term = term};
    if (options_.rule != HierarchyRule::none) step.entered_with = absent_precedents(term);
    if (options_.rule == HierarchyRule::restrict && !step.entered_with.empty()) return std::nullopt;

    const double ss_before = model.residual_ss();
    double ss_with_precedents = ss_before;
    double ss = 0.0;
    if (step.entered_with.empty()) {
      ss = model.residual_ss_with(term_column(coded_, term));
    } else {
      Sweep sweep = model;
      for (const Term& precedent : step.entered_with)
        if (!sweep.append(term_column(coded_, precedent))) return std::nullopt;
      ss_with_precedents = sweep.residual_ss();
      ss = sweep.residual_ss_with(term_column(coded_, term));
    }
    const int entered = static_cast<int>(step.entered_with.size()) + 1;
    const int df = model.residual_df() - entered;
    if (std::isnan(ss) || df < 1) return std::nullopt;

    const double mean_square = ss / df;
    const double joint_p = f_upper_tail((ss_before - ss) / entered / mean_square, entered, df);
    const double own_p = f_upper_tail((ss_with_precedents - ss) / mean_square, 1.0, df);
    step.p = options_.rule == HierarchyRule::combine ? std::max(joint_p, own_p) : joint_p;
    set_criteria(step, ss, df);
    return step;
  }

  std::vector<StepwiseStep> entering_steps() const {
    std::vector<StepwiseStep> steps;
    const Sweep sweep = sweep_of_model();
    for (const Term& candidate : candidates_) {
      if (has(terms_, candidate)) continue;
      if (std::optional<StepwiseStep> step = entering(candidate, sweep))
        steps.push_back(std::move(*step));
    }
    return steps;
  }

  bool carries_others(const Term& term) const {
    return options_.rule != HierarchyRule::none &&
           std::any_of(terms_.begin(), terms_.end(),
                       [&](const Term& other) { return has(precedents(other), term); });
  }

  std::vector<StepwiseStep> leaving_steps() const {
    std::vector<StepwiseStep> steps;
    if (terms_.empty()) return steps;
    const LeastSquaresFit fit = fit_model();
    for (std::size_t j = 0; j < terms_.size(); ++j) {
      if (carries_others(terms_[j])) continue;
      const auto column = static_cast<Eigen::Index>(j) + 1;
      StepwiseStep step{.action = Action::leave, .term = terms_[j], .p = fit.p(column)};
      const double explained = fit.coefficients(column) * fit.coefficients(column) /
                               fit.unscaled_covariance(column, column);
      set_criteria(step, fit.residual_ss + explained, fit.residual_df + 1);
      steps.push_back(std::move(step));
    }
    return steps;
  }

  /// The first of the best steps by `better`.
  template <typename Better>
  static std::optional<StepwiseStep> first(std::vector<StepwiseStep> steps, Better better) {
    const auto best = std::min_element(steps.begin(), steps.end(), better);
    if (best == steps.end()) return std::nullopt;
    return std::move(*best);
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
  const std::vector<int>& blocks_;
  const StepwiseOptions& options_;
  double p_leave_;
  std::vector<Term> terms_;
};

}  // namespace

StepwiseResult stepwise_regression(const Matrix& coded, const Vector& y,
                                   const std::vector<std::string>& factors,
                                   const std::vector<Term>& candidates,
                                   const StepwiseOptions& options, const std::vector<int>& blocks) {
  check_input(coded, y, factors, candidates, options, blocks);
  return Selection(coded, y, factors, candidates, options, blocks).run();
}

}  // namespace repose::doe
