// Which parameters matter: every repetition of a screening design analysed alone, then a vote.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "repose/doe/effect_size.hpp"
#include "repose/doe/fit_dsd.hpp"
#include "repose/doe/regression_diagnostics.hpp"
#include "repose/doe/stepwise.hpp"
#include "repose/doe/variance.hpp"

namespace repose::doe {

struct ScreeningOptions {
  enum class Method { stepwise, fit_dsd };
  Method method = Method::stepwise;
  /// A term is significant if its p < alpha in the final model; in (0, 1). Also the threshold of
  /// entering in stepwise regression.
  double alpha = 0.01;
  /// A term leaves the stepwise model if its p is above this; in (0, 1), raised to alpha if below
  /// it. Larger than alpha, terms that stand out little do not inflate the error of those that
  /// stay.
  double p_leave = 0.1;
  /// A factor is selected if, for one response at least, it is significant in this share of the
  /// repetitions; in (0, 1].
  double vote_share = 0.8;
  CandidateTerms candidates = CandidateTerms::main_and_second_order;  ///< stepwise only
  StepDirection direction = StepDirection::mixed;                     ///< stepwise only
  HierarchyRule rule = HierarchyRule::combine;                        ///< stepwise only
  StoppingRule stop = StoppingRule::p_value;                          ///< stepwise only
  FitDsdOptions fit_dsd = {};                                         ///< fit_dsd only
};

/// What the analysis of one repetition ended with.
struct FinalModel {
  std::vector<Term> terms;
  std::vector<Eigen::Index> runs;  ///< that it was fitted to; the others failed
  LeastSquaresFit fit;             ///< of intercept, terms and blocks, in this order
  RegressionDiagnostics diagnostics;
  LackOfFit lack_of_fit;
  InformationCriteria criteria;
  std::optional<FitDsdResult> two_stage;  ///< fit_dsd only: both stages
};

/// One response; vectors have one value a factor unless said otherwise.
struct ResponseScreening {
  std::string response;
  Vector count;  ///< repetitions in which the factor or a term that contains it is significant
  Vector main_effect_count;  ///< repetitions in which its main effect is
  Matrix significant;        ///< factors x repetitions: 1 where it is, else 0
  Matrix p_values;           ///< factors x repetitions, of which `p_value` is the median
  Vector sign;               ///< of `effect`: -1, 0 or 1
  /// Median over repetitions of the smallest p of the factor's terms in the final model; of its
  /// main effect if it were added, when it has none there.
  Vector p_value;
  /// Of the main effect in the fit of all repetitions together, tested against the variance between
  /// repetitions of a run; NaN without repetitions, or if they differ by no more than rounding.
  Vector pooled_p_value;
  /// The smallest false-discovery rate at which the pooled test calls the factor active, all
  /// factors and responses of the screening being one family [BenjaminiHochberg1995].
  Vector false_discovery_rate;
  Vector pooled_standard_error;  ///< of the main effect in that fit; NaN without repetitions
  Vector effect;     ///< coefficient of the main effect in coded units, mean over repetitions
  Vector run_means;  ///< one a run, over its repetitions; NaN where all failed
  VarianceDecomposition variance;
  SignalToRepetition signal;       ///< alpha; NaN without repetitions
  std::vector<FinalModel> models;  ///< of the repetitions
};

struct Screening {
  std::vector<std::string> factors;
  int repetitions = 0;
  std::vector<ResponseScreening> responses;
  std::vector<bool> selected;  ///< of the factors
};

/// `coded` is runs x factors; responses[r] is runs x repetitions, the same number for all. NaN
/// marks a failed run: it is left out of that repetition. Each repetition must keep two runs more
/// than there are factors and estimable main effects. `blocks` numbers the block of each run, empty
/// for none; blocks are in every model. Throws InputError naming response and repetition otherwise.
Screening screen(const Matrix& coded, const std::vector<std::string>& factors,
                 const std::vector<std::string>& response_names,
                 const std::vector<Matrix>& responses, const ScreeningOptions& options = {},
                 const std::vector<int>& blocks = {});

/// Means of the rows of runs x repetitions without missing values; NaN for a row without any.
Vector run_means(const Matrix& values);

/// Whether chance moves a response more than the parameters do: an unbiased share below one half,
/// or runs that the F test cannot tell from noise at 0.01. False without repetitions.
bool is_stochastic(const VarianceDecomposition& variance);

/// Adjusted p values p_(i) min_{j >= i} m/j p_(j) of m tests [BenjaminiHochberg1995]: those below q
/// have an expected share of at most q that is false. NaN stays NaN and does not count. Throws
/// InputError for a value outside [0, 1].
Vector false_discovery_rates(const Vector& p);

/// Factor i is selected if counts[r][i] >= share * repetitions for one response r at least
/// [Hadi2026, section 5.3.3]. Throws InputError if lengths differ or share is not in (0, 1].
std::vector<bool> vote(const std::vector<Vector>& counts, int repetitions, double share);

}  // namespace repose::doe
