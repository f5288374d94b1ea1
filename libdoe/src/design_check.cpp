// The check of a design: is it a definitive screening design?
#include "repose/doe/design_check.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "fold_over.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::doe {
namespace {

constexpr double kSameLevel = 1e-9;  // decoded and coded again, a level keeps its first nine digits
constexpr double kNoProduct = 1e-6;  // sums of products of such levels over at most a thousand runs

void check_matrix(const Matrix& coded) {
  if (coded.rows() == 0 || coded.cols() == 0)
    throw InputError("design: it has no runs or no factors");
  for (Eigen::Index run = 0; run < coded.rows(); ++run)
    for (Eigen::Index factor = 0; factor < coded.cols(); ++factor)
      if (!(std::abs(coded(run, factor)) <= 1.0 + kSameLevel))
        throw InputError(
            fmt::format("design: run {}, factor {} has the level {}; coded levels lie in "
                        "[-1, 1]: code the design first",
                        run + 1, factor + 1, coded(run, factor)));
}

std::string numbers_from_one(const std::vector<int>& runs) {
  std::vector<std::string> texts;
  for (const int run : runs) texts.push_back(std::to_string(run + 1));
  return listed(texts);
}

double largest_offdiagonal(Matrix square) {
  square.diagonal().setZero();
  return square.cwiseAbs().maxCoeff();
}

Matrix correlations(const Matrix& coded) {
  Matrix centred = coded.rowwise() - coded.colwise().mean();
  for (Eigen::Index j = 0; j < centred.cols(); ++j) {
    const double norm = centred.col(j).norm();
    if (norm > 0.0) centred.col(j) /= norm;
  }
  Matrix r = (centred.transpose() * centred).cwiseMin(1.0).cwiseMax(-1.0);
  r.diagonal().setOnes();
  return r;
}

void list_aliases(const Matrix& coded, const Eigen::ColPivHouseholderQR<Matrix>& qr,
                  DesignCheck& check) {
  double sum_of_squares = 0.0;
  int second_order_terms = 0;
  for (const Term& term : candidate_terms(check.factors, CandidateTerms::main_and_second_order)) {
    if (term.kind == Term::Kind::main_effect) continue;
    ++second_order_terms;
    const Vector coefficients = qr.solve(term_column(coded, term)).tail(check.factors);
    for (int factor = 0; factor < check.factors; ++factor) {
      if (std::abs(coefficients(factor)) < kSameLevel) continue;
      check.aliases.push_back({factor, term, coefficients(factor)});
      sum_of_squares += coefficients(factor) * coefficients(factor);
    }
  }
  std::stable_sort(check.aliases.begin(), check.aliases.end(), [](const Alias& a, const Alias& b) {
    return std::abs(a.coefficient) > std::abs(b.coefficient);
  });
  if (!check.aliases.empty()) check.alias_max = std::abs(check.aliases.front().coefficient);
  check.alias_rms = std::sqrt(sum_of_squares / (check.factors * second_order_terms));
}

/// What the fit of intercept and main effects can tell.
void judge_main_effects(const Matrix& coded, DesignCheck& check) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  check.residual_df = check.runs - check.factors - 1;
  check.two_stage_df = std::max(0, static_cast<int>(check.pairs.size()) - check.factors +
                                       std::max(0, static_cast<int>(check.centre_runs.size()) - 1));
  check.standard_error = Vector::Constant(check.factors, kInfinity);
  check.alias_max = check.alias_rms = kInfinity;
  const Matrix x =
      model_matrix(coded, candidate_terms(check.factors, CandidateTerms::main_effects));
  if (x.rows() < x.cols()) return;
  const Eigen::ColPivHouseholderQR<Matrix> qr(x);
  if (qr.rank() < x.cols()) return;
  check.alias_max = 0.0;
  list_aliases(coded, qr, check);
  const auto p = static_cast<double>(x.cols());
  check.d_efficiency =
      std::exp(2.0 * qr.matrixR().diagonal().cwiseAbs().array().log().sum() / p) / check.runs;
  const Matrix pseudo_inverse = qr.solve(Matrix::Identity(x.rows(), x.rows()));
  check.standard_error = pseudo_inverse.bottomRows(check.factors).rowwise().norm();
}

std::vector<int> runs_with_other_levels(const Matrix& coded) {
  std::vector<int> runs;
  for (Eigen::Index run = 0; run < coded.rows(); ++run) {
    const auto off = (coded.row(run).array() - coded.row(run).array().round()).abs();
    if (off.maxCoeff() > kSameLevel) runs.push_back(static_cast<int>(run));
  }
  return runs;
}

std::vector<int> runs_with_several_zeros(const Matrix& coded, const std::vector<int>& centre_runs) {
  std::vector<int> runs;
  for (int run = 0; run < coded.rows(); ++run) {
    const auto zeros = (coded.row(run).array().abs() <= kSameLevel).count();
    const bool centre = std::find(centre_runs.begin(), centre_runs.end(), run) != centre_runs.end();
    if (zeros > 1 && !centre) runs.push_back(run);
  }
  return runs;
}

void list_problems(const Matrix& coded, DesignCheck& check) {
  const std::vector<int> other_levels = runs_with_other_levels(coded);
  if (!other_levels.empty())
    check.problems.push_back("runs with levels other than low, middle and high: " +
                             numbers_from_one(other_levels));
  if (check.centre_runs.empty()) check.problems.push_back("there is no centre run");
  if (!check.orphans.empty())
    check.problems.push_back("runs without a mirror image: " + numbers_from_one(check.orphans));
  const std::vector<int> several_zeros = runs_with_several_zeros(coded, check.centre_runs);
  if (!several_zeros.empty())
    check.problems.push_back("runs with several factors at the middle: " +
                             numbers_from_one(several_zeros));
  if (std::isinf(check.alias_max))
    check.problems.push_back("the main effects cannot all be estimated");
  else if (check.alias_max > 0.0)
    check.problems.push_back(fmt::format(
        "main effects are aliased with second-order effects, by up to {:.3g}", check.alias_max));
}

/// Factors that are never at the middle, in a design where others are.
std::vector<int> two_level_factors(const Matrix& coded) {
  std::vector<int> factors;
  for (int j = 0; j < coded.cols(); ++j)
    if (coded.col(j).cwiseAbs().minCoeff() > kSameLevel) factors.push_back(j);
  if (static_cast<Eigen::Index>(factors.size()) == coded.cols()) factors.clear();
  return factors;
}

/// Fold-over structure in which a run with every three-level factor at the middle is a centre run.
FoldOver structure_of(const Matrix& coded, const std::vector<int>& two_level) {
  const FoldOver found = find_fold_over(coded);
  if (two_level.empty()) return found;
  const auto is_centre = [&](int run) {
    Vector row = coded.row(run).transpose();
    for (const int factor : two_level) row[factor] = 0.0;
    return row.cwiseAbs().maxCoeff() <= kSameLevel;
  };
  FoldOver result;
  for (const auto& pair : found.pairs) {
    if (is_centre(pair.first))
      result.centre_runs.insert(result.centre_runs.end(), {pair.first, pair.second});
    else
      result.pairs.push_back(pair);
  }
  for (const int run : found.orphans)
    (is_centre(run) ? result.centre_runs : result.orphans).push_back(run);
  std::sort(result.centre_runs.begin(), result.centre_runs.end());
  return result;
}

}  // namespace

FoldOver find_fold_over(const Matrix& coded) {
  FoldOver result;
  const int runs = static_cast<int>(coded.rows());
  std::vector<bool> taken(static_cast<std::size_t>(runs), false);
  for (int run = 0; run < runs; ++run) {
    if (taken[static_cast<std::size_t>(run)]) continue;
    if (coded.row(run).cwiseAbs().maxCoeff() <= kSameLevel) {
      result.centre_runs.push_back(run);
      continue;
    }
    int partner = run + 1;
    while (partner < runs &&
           (taken[static_cast<std::size_t>(partner)] ||
            (coded.row(run) + coded.row(partner)).cwiseAbs().maxCoeff() > kSameLevel))
      ++partner;
    if (partner == runs) {
      result.orphans.push_back(run);
    } else {
      taken[static_cast<std::size_t>(partner)] = true;
      result.pairs.emplace_back(run, partner);
    }
  }
  return result;
}

DesignCheck check_design(const Matrix& coded) {
  check_matrix(coded);
  DesignCheck check;
  check.two_level_factors = two_level_factors(coded);
  FoldOver fold_over = structure_of(coded, check.two_level_factors);
  check.runs = static_cast<int>(coded.rows());
  check.factors = static_cast<int>(coded.cols());
  check.pairs = std::move(fold_over.pairs);
  check.centre_runs = std::move(fold_over.centre_runs);
  check.orphans = std::move(fold_over.orphans);
  check.column_sum_max = coded.colwise().sum().cwiseAbs().maxCoeff();
  check.gram_offdiagonal_max = largest_offdiagonal(coded.transpose() * coded);
  if (check.column_sum_max < kNoProduct) check.column_sum_max = 0.0;
  if (check.gram_offdiagonal_max < kNoProduct) check.gram_offdiagonal_max = 0.0;
  check.correlation = correlations(coded);
  check.correlation_max = largest_offdiagonal(check.correlation);
  judge_main_effects(coded, check);
  list_problems(coded, check);
  return check;
}

Matrix missing_runs(const Matrix& coded) {
  check_matrix(coded);
  const std::vector<int> two_level = two_level_factors(coded);
  const std::vector<int> orphans = find_fold_over(coded).orphans;
  const bool centred = !structure_of(coded, two_level).centre_runs.empty();
  const auto mirrored = static_cast<Eigen::Index>(orphans.size());
  const Eigen::Index centres = centred ? 0 : (two_level.empty() ? 1 : 2);
  Matrix runs = Matrix::Zero(mirrored + centres, coded.cols());
  for (Eigen::Index i = 0; i < mirrored; ++i)
    runs.row(i) = -coded.row(orphans[static_cast<std::size_t>(i)]);
  for (Eigen::Index i = 0; i < centres; ++i)
    for (const int factor : two_level) runs(mirrored + i, factor) = i == 0 ? -1.0 : 1.0;
  runs.array() += 0.0;  // no negative zeros
  return runs;
}

}  // namespace repose::doe
