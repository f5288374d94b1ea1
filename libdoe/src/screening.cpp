// Screening: each repetition analysed alone, then a vote.
#include "repose/doe/screening.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "sweep.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The runs of one repetition that did not fail.
struct Repetition {
  std::vector<Eigen::Index> runs;
  Matrix coded;
  Vector y;
  std::vector<int> blocks;
};

/// Of some runs; empty if there are no blocks.
std::vector<int> blocks_of(const std::vector<int>& blocks, const std::vector<Eigen::Index>& runs) {
  std::vector<int> result;
  if (!blocks.empty())
    for (const Eigen::Index run : runs) result.push_back(blocks[static_cast<std::size_t>(run)]);
  return result;
}

Repetition surviving_runs(const Matrix& coded, const Vector& y, const std::vector<int>& blocks) {
  Repetition repetition;
  for (Eigen::Index run = 0; run < y.size(); ++run) {
    if (std::isnan(y(run))) continue;
    repetition.runs.push_back(run);
  }
  repetition.blocks = blocks_of(blocks, repetition.runs);
  repetition.coded = coded(repetition.runs, Eigen::all);
  repetition.y = y(repetition.runs);
  return repetition;
}

FinalModel final_model(const Repetition& repetition, const std::vector<std::string>& factors,
                       const ScreeningOptions& options) {
  FinalModel model{.runs = repetition.runs};
  if (options.method == ScreeningOptions::Method::fit_dsd) {
    FitDsdResult result = fit_definitive_screening(repetition.coded, repetition.y, factors,
                                                   options.fit_dsd, repetition.blocks);
    model.terms = result.terms;
    model.fit = result.fit;
    model.runs.clear();
    for (const int run : result.runs)
      model.runs.push_back(repetition.runs[static_cast<std::size_t>(run)]);
    model.two_stage = std::move(result);
  } else {
    StepwiseResult result =
        stepwise_regression(repetition.coded, repetition.y, factors,
                            candidate_terms(static_cast<int>(factors.size()), options.candidates),
                            {.stop = options.stop,
                             .direction = options.direction,
                             .rule = options.rule,
                             .p_enter = options.alpha,
                             .p_leave = options.p_leave},
                            repetition.blocks);
    model.terms = std::move(result.terms);
    model.fit = std::move(result.fit);
  }
  return model;
}

void diagnose(const Matrix& coded, const Vector& y, const std::vector<int>& blocks,
              FinalModel& model) {
  const std::vector<int> used_blocks = blocks_of(blocks, model.runs);
  const Matrix levels = coded(model.runs, Eigen::all);
  const Matrix x = model_matrix(levels, model.terms, used_blocks);
  const Vector used = y(model.runs);
  Matrix points(levels.rows(), levels.cols() + 1);
  points << levels, Vector::Zero(levels.rows());
  for (std::size_t i = 0; i < used_blocks.size(); ++i)
    points(static_cast<Eigen::Index>(i), levels.cols()) = used_blocks[i];
  model.diagnostics = diagnose_regression(x, used);
  model.lack_of_fit = lack_of_fit(x, used, points);
  model.criteria = information_criteria(model.fit.residual_ss, static_cast<int>(x.rows()),
                                        static_cast<int>(x.cols()));
}

/// p of a column if it were added to the model; 1 if it cannot be.
double p_if_added(const Sweep& model, const Vector& column) {
  const int df = model.residual_df() - 1;
  if (model.is_exact() || df < 1) return 1.0;
  const double ss = model.residual_ss_with(column);
  const double p = f_upper_tail((model.residual_ss() - ss) / (ss / df), 1.0, df);
  return std::isnan(p) ? 1.0 : p;
}

/// The smallest p of the terms that contain the factor.
double p_of_factor(const FinalModel& model, const Sweep& sweep, const Matrix& coded, int factor) {
  double smallest = kNaN;
  for (std::size_t j = 0; j < model.terms.size(); ++j)
    if (model.terms[j].contains(factor))
      smallest = std::fmin(smallest, model.fit.p(static_cast<Eigen::Index>(j) + 1));
  return std::isnan(smallest) ? p_if_added(sweep, coded.col(factor)) : smallest;
}

bool main_effect_is_significant(const FinalModel& model, int factor, double alpha) {
  const auto at = std::find(model.terms.begin(), model.terms.end(), main_effect(factor));
  return at != model.terms.end() && model.fit.p(at - model.terms.begin() + 1) < alpha;
}

bool is_significant(const FinalModel& model, int factor, double alpha) {
  for (std::size_t j = 0; j < model.terms.size(); ++j)
    if (model.terms[j].contains(factor) && model.fit.p(static_cast<Eigen::Index>(j) + 1) < alpha)
      return true;
  return false;
}

double median(Vector values) {
  std::sort(values.begin(), values.end());
  const Eigen::Index n = values.size();
  return n % 2 == 1 ? values(n / 2) : 0.5 * (values(n / 2 - 1) + values(n / 2));
}

/// NaN where too few runs are repeated.
SignalToRepetition signal_of(const Matrix& values) {
  const auto repeated = (values.array().isNaN() == false).rowwise().count();
  if ((repeated >= 2).count() < 2) return {kNaN, kNaN};
  return signal_to_repetition(values);
}

/// Main effects of all repetitions together, tested against the variance within runs. The fit to
/// the runs' means, weighted by their number of values, has the coefficients of the fit to all
/// values.
void pool(const Matrix& coded, const Matrix& values, const std::vector<std::string>& factors,
          const std::vector<int>& blocks, ResponseScreening& result) {
  const VarianceDecomposition& variance = result.variance;
  const auto k = static_cast<Eigen::Index>(factors.size());
  const int within_df = variance.observations - variance.runs;
  result.pooled_p_value = result.pooled_standard_error = Vector::Constant(k, kNaN);
  const double largest = (values.array().isNaN()).select(0.0, values).cwiseAbs().maxCoeff();
  if (within_df == 0 || variance.within_ss <= negligible_ss(largest, variance.observations)) return;
  std::vector<Eigen::Index> runs;
  std::vector<double> root_weight;
  for (Eigen::Index run = 0; run < values.rows(); ++run) {
    if (std::isnan(result.run_means(run))) continue;
    runs.push_back(run);
    const auto count = values.cols() - values.row(run).array().isNaN().count();
    root_weight.push_back(std::sqrt(static_cast<double>(count)));
  }
  const Eigen::Map<const Vector> weight(root_weight.data(),
                                        static_cast<Eigen::Index>(root_weight.size()));
  const std::vector<int> used_blocks = blocks_of(blocks, runs);
  const std::vector<Term> terms =
      candidate_terms(static_cast<int>(k), CandidateTerms::main_effects);
  const LeastSquaresFit fit = fit_least_squares(
      weight.asDiagonal() * model_matrix(coded(runs, Eigen::all), terms, used_blocks),
      weight.cwiseProduct(result.run_means(runs)), column_names(terms, factors, used_blocks));
  for (Eigen::Index j = 0; j < k; ++j) {
    const double error = std::sqrt(fit.unscaled_covariance(j + 1, j + 1) * variance.within_ms);
    result.pooled_standard_error(j) = error;
    result.pooled_p_value(j) = t_two_sided(fit.coefficients(j + 1) / error, within_df);
  }
}

void check_input(const Matrix& coded, const std::vector<std::string>& factors,
                 const std::vector<std::string>& names, const std::vector<Matrix>& responses,
                 const ScreeningOptions& options, const std::vector<int>& blocks) {
  if (!blocks.empty() && static_cast<Eigen::Index>(blocks.size()) != coded.rows())
    throw InputError(fmt::format("screening: blocks of {} runs for a design of {} runs",
                                 blocks.size(), coded.rows()));
  if (factors.empty() || static_cast<Eigen::Index>(factors.size()) != coded.cols())
    throw InputError(fmt::format("screening: {} factor names for a design of {} factors",
                                 factors.size(), coded.cols()));
  if (!coded.allFinite()) throw InputError("screening: the design has a level that is not finite");
  if (responses.empty() || names.size() != responses.size())
    throw InputError(fmt::format("screening: {} response names for {} responses", names.size(),
                                 responses.size()));
  for (std::size_t r = 0; r < responses.size(); ++r) {
    if (responses[r].rows() != coded.rows() || responses[r].cols() < 1 ||
        responses[r].cols() != responses.front().cols())
      throw InputError(
          fmt::format("screening: response {} has {} runs x {} repetitions; the design has {} "
                      "runs and the first response {} repetitions",
                      names[r], responses[r].rows(), responses[r].cols(), coded.rows(),
                      responses.front().cols()));
    if (responses[r].array().isInf().any())
      throw InputError(fmt::format(
          "screening: response {} has an infinite value; mark failed runs as NaN", names[r]));
  }
  for (const double threshold : {options.alpha, options.p_leave})
    if (!(threshold > 0.0 && threshold < 1.0))
      throw InputError(
          fmt::format("screening: the threshold {} of p values is not in (0, 1)", threshold));
}

void require_enough_runs(const Repetition& repetition, std::size_t factors,
                         const std::string& response, Eigen::Index number) {
  if (repetition.y.size() < static_cast<Eigen::Index>(factors + 2))
    throw InputError(
        fmt::format("screening: response {}, repetition {}: {} runs have a value; {} factors "
                    "need at least {}: repeat the failed runs or leave this repetition out",
                    response, number + 1, repetition.y.size(), factors, factors + 2));
}

ResponseScreening screen_response(const Matrix& coded, const std::vector<std::string>& factors,
                                  const std::string& name, const Matrix& values,
                                  const ScreeningOptions& options, const std::vector<int>& blocks) {
  const int k = static_cast<int>(factors.size());
  const Eigen::Index repetitions = values.cols();
  const std::vector<Term> main_effects = candidate_terms(k, CandidateTerms::main_effects);
  Matrix effect(k, repetitions);
  ResponseScreening result;
  result.response = name;
  result.significant = result.p_values = Matrix::Zero(k, repetitions);
  result.main_effect_count = Vector::Zero(k);
  for (Eigen::Index r = 0; r < repetitions; ++r) {
    const Repetition repetition = surviving_runs(coded, values.col(r), blocks);
    require_enough_runs(repetition, factors.size(), name, r);
    FinalModel model;
    try {
      effect.col(r) =
          fit_least_squares(model_matrix(repetition.coded, main_effects, repetition.blocks),
                            repetition.y, column_names(main_effects, factors, repetition.blocks))
              .coefficients.segment(1, k);
      model = final_model(repetition, factors, options);
      diagnose(coded, values.col(r), blocks, model);
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("screening: response {}, repetition {} ({} of {} runs have a value): {}",
                      name, r + 1, repetition.y.size(), coded.rows(), error.what()));
    }
    Sweep sweep(repetition.y);
    sweep.append_all(model_matrix(repetition.coded, model.terms, repetition.blocks));
    for (int factor = 0; factor < k; ++factor) {
      result.p_values(factor, r) = p_of_factor(model, sweep, repetition.coded, factor);
      result.significant(factor, r) = is_significant(model, factor, options.alpha) ? 1.0 : 0.0;
      if (main_effect_is_significant(model, factor, options.alpha))
        result.main_effect_count(factor) += 1.0;
    }
    result.models.push_back(std::move(model));
  }
  result.effect = effect.rowwise().mean();
  result.sign = result.effect.array().sign();
  result.p_value = Vector(k);
  for (int factor = 0; factor < k; ++factor)
    result.p_value(factor) = median(result.p_values.row(factor));
  result.count = result.significant.rowwise().sum();
  result.run_means = run_means(values);
  result.variance = decompose_variance(values);
  result.signal = values.cols() > 1 ? signal_of(values) : SignalToRepetition{kNaN, kNaN};
  try {
    pool(coded, values, factors, blocks, result);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("screening: response {}, all repetitions together: {}", name, error.what()));
  }
  return result;
}

void adjust_pooled_tests(std::vector<ResponseScreening>& responses, Eigen::Index factors) {
  Vector p(static_cast<Eigen::Index>(responses.size()) * factors);
  Eigen::Index from = 0;
  for (const ResponseScreening& response : responses) {
    p.segment(from, factors) = response.pooled_p_value;
    from += factors;
  }
  const Vector rates = false_discovery_rates(p);
  from = 0;
  for (ResponseScreening& response : responses) {
    response.false_discovery_rate = rates.segment(from, factors);
    from += factors;
  }
}

}  // namespace

Vector run_means(const Matrix& values) {
  Vector means(values.rows());
  for (Eigen::Index run = 0; run < values.rows(); ++run) {
    const auto present = values.row(run).array().isNaN() == false;
    means(run) =
        present.select(values.row(run).array(), 0.0).sum() / static_cast<double>(present.count());
  }
  return means;
}

bool is_stochastic(const VarianceDecomposition& variance) {
  return !std::isnan(variance.p_value) &&
         (variance.p_value >= 0.01 || variance.unbiased_share < 0.5);
}

Vector false_discovery_rates(const Vector& p) {
  std::vector<Eigen::Index> order;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    if (std::isnan(p(i))) continue;
    if (!(p(i) >= 0.0 && p(i) <= 1.0))
      throw InputError(
          fmt::format("false-discovery rate: test {} has the p value {}; it must lie "
                      "in [0, 1]",
                      i + 1, p(i)));
    order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return p(a) > p(b); });
  const auto m = static_cast<double>(order.size());
  Vector rates = Vector::Constant(p.size(), kNaN);
  double smallest = 1.0, rank = m;  // the largest p first
  for (const Eigen::Index i : order) {
    smallest = std::min(smallest, p(i) * m / rank);
    rates(i) = smallest;
    rank -= 1.0;
  }
  return rates;
}

std::vector<bool> vote(const std::vector<Vector>& counts, int repetitions, double share) {
  if (!(share > 0.0 && share <= 1.0))
    throw InputError(fmt::format("vote: a share of {} of the repetitions is not in (0, 1]", share));
  if (counts.empty() || repetitions < 1)
    throw InputError(fmt::format("vote: {} responses and {} repetitions; one of each is needed",
                                 counts.size(), repetitions));
  const double needed = share * repetitions * (1.0 - 1e-12);  // 0.7 * 10 is above 7 in binary
  std::vector<bool> selected(static_cast<std::size_t>(counts.front().size()), false);
  for (const Vector& count : counts) {
    if (count.size() != counts.front().size())
      throw InputError(
          fmt::format("vote: counts of {} and of {} factors", counts.front().size(), count.size()));
    for (Eigen::Index i = 0; i < count.size(); ++i)
      if (count(i) >= needed) selected[static_cast<std::size_t>(i)] = true;
  }
  return selected;
}

Screening screen(const Matrix& coded, const std::vector<std::string>& factors,
                 const std::vector<std::string>& response_names,
                 const std::vector<Matrix>& responses, const ScreeningOptions& options,
                 const std::vector<int>& blocks) {
  check_input(coded, factors, response_names, responses, options, blocks);
  Screening screening{factors, static_cast<int>(responses.front().cols()), {}, {}};
  std::vector<Vector> counts;
  for (std::size_t r = 0; r < responses.size(); ++r) {
    screening.responses.push_back(
        screen_response(coded, factors, response_names[r], responses[r], options, blocks));
    counts.push_back(screening.responses.back().count);
  }
  adjust_pooled_tests(screening.responses, coded.cols());
  screening.selected = vote(counts, screening.repetitions, options.vote_share);
  return screening;
}

}  // namespace repose::doe
