// The two-stage analysis of definitive screening designs.
#include "repose/doe/fit_dsd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "fold_over.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "sweep.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// y of a fold-over design split into the parts that change sign with the factors and that do not.
struct Split {
  Matrix half;         ///< m x k, the first run of each pair
  Vector odd;          ///< m, (y+ - y-)/2
  Matrix even_points;  ///< pairs' first runs and, if there are centre runs, one row of zeros
  Vector even;         ///< (y+ + y-)/2, mean of the centre runs
  Vector root_weight;  ///< sqrt of the runs that a row of `even` stands for
  double centre_ss = 0.0;
  std::vector<int> used_runs;
};

Split split(const Matrix& coded, const Vector& y, const FoldOver& fold_over) {
  const auto m = static_cast<Eigen::Index>(fold_over.pairs.size());
  const auto centres = static_cast<Eigen::Index>(fold_over.centre_runs.size());
  const Eigen::Index rows = m + (centres > 0 ? 1 : 0);
  Split s{Matrix(m, coded.cols()),
          Vector(m),
          Matrix::Zero(rows, coded.cols()),
          Vector::Zero(rows),
          Vector::Constant(rows, std::sqrt(2.0)),
          0.0,
          fold_over.centre_runs};
  for (Eigen::Index i = 0; i < m; ++i) {
    const auto [one, other] = fold_over.pairs[static_cast<std::size_t>(i)];
    s.half.row(i) = coded.row(one);
    s.odd(i) = 0.5 * (y(one) - y(other));
    s.even(i) = 0.5 * (y(one) + y(other));
    s.used_runs.insert(s.used_runs.end(), {one, other});
  }
  s.even_points.topRows(m) = s.half;
  if (centres > 0) {
    for (const int run : fold_over.centre_runs) s.even(m) += y(run) / static_cast<double>(centres);
    for (const int run : fold_over.centre_runs) s.centre_ss += std::pow(y(run) - s.even(m), 2);
    s.root_weight(m) = std::sqrt(static_cast<double>(centres));
  }
  std::sort(s.used_runs.begin(), s.used_runs.end());
  return s;
}

Matrix columns_of(const Matrix& matrix, const std::vector<int>& columns) {
  Matrix chosen(matrix.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    chosen.col(static_cast<Eigen::Index>(j)) = matrix.col(columns[j]);
  return chosen;
}

double stage_one_alpha(const FitDsdOptions& options, int df) {
  if (df == 1) return options.alpha_one_df;
  return df == 2 ? options.alpha_two_df : options.alpha_more_df;
}

/// Both runs of a pair carry the odd part: its sum of squares over all runs is twice that over
/// pairs.
double odd_residual_ss(const Split& s, const std::vector<int>& factors) {
  Sweep sweep(s.odd);
  for (const int factor : factors) sweep.append(s.half.col(factor));
  return 2.0 * sweep.residual_ss();
}

/// Active factors where fake factors or centre runs give an estimate of error.
std::vector<int> active_by_error_estimate(FitDsdResult& result, const FitDsdOptions& options) {
  result.alpha = stage_one_alpha(options, result.fake_df + result.centre_df);
  std::vector<int> active;
  for (int factor = 0; factor < result.p.size(); ++factor)
    if (result.p(factor) < result.alpha) active.push_back(factor);
  return active;
}

/// Without such an estimate: factors by falling |b|; the i-th is tested against what the first i
/// leave, and the i with the smallest p tells how many are active, one at least being inactive.
std::vector<int> active_by_order(const Split& s, FitDsdResult& result,
                                 const FitDsdOptions& options) {
  const int factors = static_cast<int>(result.main_effects.size());
  std::vector<int> order(static_cast<std::size_t>(factors));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::abs(result.main_effects(a)) > std::abs(result.main_effects(b));
  });
  double smallest_p = 1.0;
  result.alpha = stage_one_alpha(options, result.pairs - 1);
  std::vector<int> active;
  double ss_before = odd_residual_ss(s, {});
  for (int i = 1; i < factors; ++i) {
    const std::vector<int> first(order.begin(), order.begin() + i);
    const double ss = odd_residual_ss(s, first);
    const int df = result.pairs - i;
    const double p = f_upper_tail((ss_before - ss) / (ss / df), 1.0, df);
    if (p < smallest_p && p < stage_one_alpha(options, df)) {
      smallest_p = p;
      active = first;
      result.alpha = stage_one_alpha(options, df);
    }
    ss_before = ss;
  }
  std::sort(active.begin(), active.end());
  return active;
}

void stage_one(const Split& s, const FitDsdOptions& options,
               const std::vector<std::string>& factors, FitDsdResult& result) {
  const LeastSquaresFit odd = fit_least_squares(s.half, s.odd, factors);
  const int k = static_cast<int>(factors.size());
  result.main_effects = odd.coefficients;
  result.fake_ss = 2.0 * odd.residual_ss;
  result.fake_df = odd.residual_df;
  result.centre_ss = s.centre_ss;
  result.centre_df = std::max(0, result.centre_runs - 1);
  result.t = result.p = Vector::Constant(k, kNaN);
  const int df = result.fake_df + result.centre_df;
  if (df > 0) {
    const double s2 = (result.fake_ss + result.centre_ss) / df;
    for (int j = 0; j < k; ++j) {
      result.t(j) = odd.coefficients(j) / std::sqrt(0.5 * odd.unscaled_covariance(j, j) * s2);
      result.p(j) = t_two_sided(result.t(j), df);
    }
  }
  result.active =
      df > 0 ? active_by_error_estimate(result, options) : active_by_order(s, result, options);
  result.stage1_df = result.pairs - static_cast<int>(result.active.size()) + result.centre_df;
  result.stage1_sigma =
      std::sqrt((odd_residual_ss(s, result.active) + result.centre_ss) / result.stage1_df);

  const auto active = static_cast<Eigen::Index>(result.active.size());
  result.active_t = result.active_p = Vector(active);
  if (active == 0) return;
  const LeastSquaresFit pooled = fit_least_squares(columns_of(s.half, result.active), s.odd);
  for (Eigen::Index j = 0; j < active; ++j) {
    result.active_t(j) = pooled.coefficients(j) /
                         (result.stage1_sigma * std::sqrt(0.5 * pooled.unscaled_covariance(j, j)));
    result.active_p(j) = t_two_sided(result.active_t(j), result.stage1_df);
  }
}

std::vector<Term> second_order_candidates(const std::vector<int>& active, int factors,
                                          Heredity heredity) {
  const auto is_active = [&](int f) {
    return std::find(active.begin(), active.end(), f) != active.end();
  };
  std::vector<Term> terms;
  for (const Term& term : candidate_terms(factors, CandidateTerms::main_and_second_order)) {
    if (term.kind == Term::Kind::main_effect) continue;
    const int parents = (is_active(term.first) ? 1 : 0) + (is_active(term.second) ? 1 : 0);
    if (parents == 2 || (parents == 1 && heredity == Heredity::weak)) terms.push_back(term);
  }
  return terms;
}

/// The even part of y and the search for the second-order terms that explain it.
class EvenPart {
 public:
  EvenPart(const Split& s, std::vector<Term> candidates)
      : candidates_(std::move(candidates)), intercept_(s.root_weight.cwiseProduct(s.even)) {
    intercept_.append(s.root_weight);
    for (const Term& term : candidates_)
      columns_.push_back(s.root_weight.cwiseProduct(term_column(s.even_points, term)));
  }

  double total_ss() const { return intercept_.residual_ss(); }
  int total_df() const { return intercept_.residual_df(); }

  /// The subset of `size` candidates that leaves least; nothing if no subset can be estimated.
  std::optional<FitDsdResult::Step> best_subset(int size, double budget,
                                                const std::vector<Term>& previous) {
    best_ = FitDsdResult::Step{};
    best_.residual_ss = std::numeric_limits<double>::infinity();
    best_.exhaustive = subsets(size) <= budget;
    if (best_.exhaustive) {
      std::vector<Term> chosen;
      search(intercept_, size, 0, chosen);
    } else {
      add_one(previous);
    }
    if (std::isinf(best_.residual_ss)) return std::nullopt;
    return best_;
  }

 private:
  double subsets(int size) const {
    double count = 1.0;
    for (int i = 0; i < size; ++i) count *= (static_cast<double>(candidates_.size()) - i) / (i + 1);
    return count;
  }

  void keep_if_better(const Sweep& sweep, std::vector<Term> terms) {
    if (sweep.residual_ss() >= best_.residual_ss) return;
    best_.residual_ss = sweep.residual_ss();
    best_.terms = std::move(terms);
  }

  void search(const Sweep& sweep, int missing, std::size_t from, std::vector<Term>& chosen) {
    if (missing == 0) return keep_if_better(sweep, chosen);
    for (std::size_t next = from; next + static_cast<std::size_t>(missing) <= columns_.size();
         ++next) {
      Sweep longer = sweep;
      if (!longer.append(columns_[next])) continue;
      chosen.push_back(candidates_[next]);
      search(longer, missing - 1, next + 1, chosen);
      chosen.pop_back();
    }
  }

  void add_one(const std::vector<Term>& previous) {
    Sweep sweep = intercept_;
    const auto chosen = [&](const Term& term) {
      return std::find(previous.begin(), previous.end(), term) != previous.end();
    };
    for (std::size_t j = 0; j < columns_.size(); ++j)
      if (chosen(candidates_[j])) sweep.append(columns_[j]);
    for (std::size_t j = 0; j < columns_.size(); ++j) {
      Sweep longer = sweep;
      if (chosen(candidates_[j]) || !longer.append(columns_[j])) continue;
      std::vector<Term> terms = previous;
      terms.push_back(candidates_[j]);
      keep_if_better(longer, std::move(terms));
    }
  }

  std::vector<Term> candidates_;
  std::vector<Vector> columns_;
  Sweep intercept_;
  FitDsdResult::Step best_;
};

void stage_two(const Split& s, const FitDsdOptions& options, FitDsdResult& result) {
  const std::vector<Term> candidates =
      second_order_candidates(result.active, static_cast<int>(s.half.cols()), options.heredity);
  EvenPart even(s, candidates);
  const double s2 = result.stage1_sigma * result.stage1_sigma;
  result.second_ss = even.total_ss();
  result.second_df = even.total_df();
  result.second_f = result.second_ss / result.second_df / s2;
  result.second_p = f_upper_tail(result.second_f, result.second_df, result.stage1_df);
  if (result.active.empty() || !(result.second_p <= options.alpha_second)) return;

  const int most =
      std::min({result.pairs / 2, static_cast<int>(candidates.size()), result.second_df - 1});
  for (int size = 1; size <= most; ++size) {
    std::optional<FitDsdResult::Step> step =
        even.best_subset(size, options.subset_budget, result.second_order);
    if (!step) break;
    const int df = result.second_df - size;
    step->f = step->residual_ss / df / s2;
    step->p = f_upper_tail(step->f, df, result.stage1_df);
    result.second_order = step->terms;
    result.steps.push_back(std::move(*step));
    if (result.steps.back().p > options.alpha_second) break;
  }
}

void fit_combined(const Matrix& coded, const Vector& y, const Split& s,
                  const std::vector<std::string>& factors, FitDsdResult& result) {
  for (const int factor : result.active) result.terms.push_back(main_effect(factor));
  result.terms.insert(result.terms.end(), result.second_order.begin(), result.second_order.end());
  const auto runs = static_cast<Eigen::Index>(s.used_runs.size());
  Matrix used(runs, coded.cols());
  Vector used_y(runs);
  for (Eigen::Index i = 0; i < runs; ++i) {
    used.row(i) = coded.row(s.used_runs[static_cast<std::size_t>(i)]);
    used_y(i) = y(s.used_runs[static_cast<std::size_t>(i)]);
  }
  result.fit = fit_least_squares(model_matrix(used, result.terms), used_y,
                                 column_names(result.terms, factors));
  result.anova = analysis_of_variance(result.fit);
}

}  // namespace

FitDsdResult fit_definitive_screening(const Matrix& coded, const Vector& y,
                                      const std::vector<std::string>& factors,
                                      const FitDsdOptions& options) {
  if (static_cast<Eigen::Index>(factors.size()) != coded.cols() || coded.rows() != y.size() ||
      factors.empty())
    throw InputError(
        fmt::format("definitive screening analysis: a design of {} x {} for {} factor names "
                    "and {} responses",
                    coded.rows(), coded.cols(), factors.size(), y.size()));
  if (!coded.allFinite() || !y.allFinite())
    throw InputError("definitive screening analysis: a level or a response is not finite");
  const FoldOver fold_over = find_fold_over(coded);
  FitDsdResult result;
  result.pairs = static_cast<int>(fold_over.pairs.size());
  result.centre_runs = static_cast<int>(fold_over.centre_runs.size());
  if (fold_over.pairs.size() < factors.size() || fold_over.pairs.size() < 2)
    throw InputError(fmt::format(
        "definitive screening analysis: {} runs have their mirror image, {} single ones are left "
        "out; the "
        "{} factors need at least {} pairs: repeat the missing runs or use stepwise regression",
        2 * fold_over.pairs.size(), fold_over.orphans.size(), factors.size(),
        std::max<std::size_t>(2, factors.size())));
  const Split s = split(coded, y, fold_over);
  stage_one(s, options, factors, result);
  stage_two(s, options, result);
  fit_combined(coded, y, s, factors, result);
  return result;
}

}  // namespace repose::doe
