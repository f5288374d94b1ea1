// The two-stage analysis of definitive screening designs.
#include "repose/doe/fit_dsd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "best_subset.hpp"
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
  Matrix even_points;  ///< pairs' first runs, then a row of zeros for the centre runs of each block
  Vector even;         ///< (y+ + y-)/2, means of centre runs
  Vector root_weight;  ///< sqrt of the runs that a row of `even` stands for
  std::vector<int> even_blocks;  ///< of the rows of `even`; empty without blocks
  double centre_ss = 0.0;        ///< pure error of centre runs of the same block
  int centre_df = 0;
  std::vector<int> used_runs;
};

int block_of(const std::vector<int>& blocks, int run) {
  return blocks.empty() ? 0 : blocks[static_cast<std::size_t>(run)];
}

Split split(const Matrix& coded, const Vector& y, const FoldOver& fold_over,
            const std::vector<int>& blocks) {
  std::map<int, std::vector<int>> centres;  // by block
  for (const int run : fold_over.centre_runs) centres[block_of(blocks, run)].push_back(run);
  const auto m = static_cast<Eigen::Index>(fold_over.pairs.size());
  const Eigen::Index rows = m + static_cast<Eigen::Index>(centres.size());
  Split s{.half = Matrix(m, coded.cols()),
          .odd = Vector(m),
          .even_points = Matrix::Zero(rows, coded.cols()),
          .even = Vector::Zero(rows),
          .root_weight = Vector::Constant(rows, std::sqrt(2.0)),
          .used_runs = fold_over.centre_runs};
  for (Eigen::Index i = 0; i < m; ++i) {
    const auto [one, other] = fold_over.pairs[static_cast<std::size_t>(i)];
    if (block_of(blocks, one) != block_of(blocks, other))
      throw InputError(fmt::format(
          "definitive screening analysis: run {} is in block {} and its mirror image, run {}, in "
          "block {}; both runs of a pair must be in one block, or leave the blocks out",
          one + 1, block_of(blocks, one), other + 1, block_of(blocks, other)));
    s.half.row(i) = coded.row(one);
    s.odd(i) = 0.5 * (y(one) - y(other));
    s.even(i) = 0.5 * (y(one) + y(other));
    s.used_runs.insert(s.used_runs.end(), {one, other});
    if (!blocks.empty()) s.even_blocks.push_back(block_of(blocks, one));
  }
  s.even_points.topRows(m) = s.half;
  Eigen::Index row = m;
  for (const auto& [block, runs] : centres) {
    const auto count = static_cast<double>(runs.size());
    for (const int run : runs) s.even(row) += y(run) / count;
    for (const int run : runs) s.centre_ss += std::pow(y(run) - s.even(row), 2);
    s.centre_df += static_cast<int>(runs.size()) - 1;
    s.root_weight(row++) = std::sqrt(count);
    if (!blocks.empty()) s.even_blocks.push_back(block);
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
  result.centre_df = s.centre_df;
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
                                          const FitDsdOptions& options) {
  const auto is_active = [&](int f) {
    return std::find(active.begin(), active.end(), f) != active.end();
  };
  const auto admits = [](Heredity heredity, bool all, bool one) {
    return heredity == Heredity::none || (heredity == Heredity::weak ? one : all);
  };
  std::vector<Term> terms;
  for (const Term& term : candidate_terms(factors, CandidateTerms::main_and_second_order)) {
    if (term.kind == Term::Kind::main_effect) continue;
    const bool first = is_active(term.first), second = is_active(term.second);
    const Heredity heredity =
        term.kind == Term::Kind::quadratic ? options.quadratics : options.interactions;
    if (admits(heredity, first && second, first || second)) terms.push_back(term);
  }
  return terms;
}

/// The search for second-order terms that explain the even part of y, beside intercept and blocks.
SubsetSearch search_of(const Split& s, const std::vector<Term>& candidates) {
  const Matrix base = s.root_weight.asDiagonal() * model_matrix(s.even_points, {}, s.even_blocks);
  Matrix columns(s.even.size(), static_cast<Eigen::Index>(candidates.size()));
  for (std::size_t j = 0; j < candidates.size(); ++j)
    columns.col(static_cast<Eigen::Index>(j)) =
        s.root_weight.cwiseProduct(term_column(s.even_points, candidates[j]));
  return {s.root_weight.cwiseProduct(s.even), base, std::move(columns)};
}

void stage_two(const Split& s, const FitDsdOptions& options, FitDsdResult& result) {
  const std::vector<Term> candidates =
      second_order_candidates(result.active, static_cast<int>(s.half.cols()), options);
  SubsetSearch search = search_of(s, candidates);
  const double s2 = result.stage1_sigma * result.stage1_sigma;
  result.second_ss = search.residual_ss_of_base();
  result.second_df = search.residual_df_of_base();
  result.second_f = result.second_ss / result.second_df / s2;
  result.second_p = f_upper_tail(result.second_f, result.second_df, result.stage1_df);
  if (result.active.empty() || !(result.second_p <= options.alpha_second)) return;

  const int cap = options.most_second_order < 0 ? result.pairs / 2 : options.most_second_order;
  const int most = std::min({cap, static_cast<int>(candidates.size()), result.second_df - 1});
  std::vector<int> chosen;
  std::int64_t budget = options.search_budget;
  for (int size = 1; size <= most; ++size) {
    const std::optional<BestSubset> best = search.best(size, budget, chosen);
    if (!best) break;
    budget -= best->nodes;
    chosen = best->columns;
    FitDsdResult::Step step{
        .residual_ss = best->residual_ss, .exact = best->exact, .nodes = best->nodes};
    for (const int column : chosen)
      step.terms.push_back(candidates[static_cast<std::size_t>(column)]);
    const int df = result.second_df - size;
    step.f = step.residual_ss / df / s2;
    step.p = f_upper_tail(step.f, df, result.stage1_df);
    result.second_order = step.terms;
    result.steps.push_back(std::move(step));
    if (result.steps.back().p > options.alpha_second) break;
  }
}

void fit_combined(const Matrix& coded, const Vector& y, const Split& s,
                  const std::vector<std::string>& factors, const std::vector<int>& blocks,
                  FitDsdResult& result) {
  for (const int factor : result.active) result.terms.push_back(main_effect(factor));
  result.terms.insert(result.terms.end(), result.second_order.begin(), result.second_order.end());
  result.runs = s.used_runs;
  const Matrix used = coded(s.used_runs, Eigen::all);
  const Vector used_y = y(s.used_runs);
  std::vector<int> used_blocks;
  if (!blocks.empty())
    for (const int run : s.used_runs) used_blocks.push_back(blocks[static_cast<std::size_t>(run)]);
  result.fit = fit_least_squares(model_matrix(used, result.terms, used_blocks), used_y,
                                 column_names(result.terms, factors, used_blocks));
  result.anova = analysis_of_variance(used, used_y, factors, result.terms,
                                      SumsOfSquares::type_three, used_blocks);
}

void check_input(const Matrix& coded, const Vector& y, const std::vector<std::string>& factors,
                 const FitDsdOptions& options, const std::vector<int>& blocks) {
  if (static_cast<Eigen::Index>(factors.size()) != coded.cols() || coded.rows() != y.size() ||
      factors.empty() || (!blocks.empty() && static_cast<Eigen::Index>(blocks.size()) != y.size()))
    throw InputError(
        fmt::format("definitive screening analysis: a design of {} x {} for {} factor names, {} "
                    "responses and {} blocks of runs",
                    coded.rows(), coded.cols(), factors.size(), y.size(), blocks.size()));
  if (!coded.allFinite() || !y.allFinite())
    throw InputError("definitive screening analysis: a level or a response is not finite");
  for (const double alpha :
       {options.alpha_one_df, options.alpha_two_df, options.alpha_more_df, options.alpha_second})
    if (!(alpha > 0.0 && alpha < 1.0))
      throw InputError(fmt::format(
          "definitive screening analysis: the threshold {} of p values is not in (0, 1)", alpha));
  if (options.search_budget < 1)
    throw InputError(fmt::format(
        "definitive screening analysis: a search budget of {} nodes; at least one is needed",
        options.search_budget));
}

}  // namespace

FitDsdResult fit_definitive_screening(const Matrix& coded, const Vector& y,
                                      const std::vector<std::string>& factors,
                                      const FitDsdOptions& options,
                                      const std::vector<int>& blocks) {
  check_input(coded, y, factors, options, blocks);
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
  const Split s = split(coded, y, fold_over, blocks);
  stage_one(s, options, factors, result);
  stage_two(s, options, result);
  fit_combined(coded, y, s, factors, blocks, result);
  return result;
}

}  // namespace repose::doe
