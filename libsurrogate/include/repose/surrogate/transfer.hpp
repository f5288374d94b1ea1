// A model of known configurations adapted to a new one, of which there are few runs.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/presets.hpp"

namespace repose::surrogate {

/// Source: the rows of the known configurations; target: those of the new one.
enum class TransferMethod {
  /// The hyper-parameters of the source kept, fitted to the rows of both [Hadi2026, 4.18].
  retrained,
  target_only,      ///< the source not used: what transfer must not be worse than
  shift_and_scale,  ///< b + a f_s(x) by least squares; the shift alone below four points
  /// The source's mean as a regression function of a Gaussian process of the target, its variance
  /// added: b + a f_s(x) + a process with length scales of its own [KennedyOHagan2000].
  source_basis,
  /// Two correlated functions, see CoregionalisedProcess.
  coregionalised,
  /// target_only, source_basis and coregionalised, weighted by (mean square error of the target
  /// rows when left out)^(-n/10), n different points; likewise shift_and_scale and retrained where
  /// their error is less than 0.4 of that of target_only. Of sources that are no Gaussian process:
  /// retrained, target_only and shift_and_scale. Below four different points shift_and_scale alone.
  weighted,
};
const char* to_string(TransferMethod method);
/// Throws InputError with all names.
TransferMethod transfer_method_named(std::string_view name);
/// Throws InputError for source_basis and coregionalised of a preset that is no Gaussian process of
/// the response itself.
void check_possible(TransferMethod method, const std::string& preset);

struct TransferOptions {
  TransferMethod method = TransferMethod::weighted;
  std::uint64_t seed = 1;
};

/// A method that was tried, and how well it predicts target rows left out (each point in turn, or
/// 20 folds of points where there are more).
struct TransferPart {
  TransferMethod method = TransferMethod::weighted;
  double weight = 0.0;
  double left_out_rmse = std::numeric_limits<double>::quiet_NaN();
  std::string failure;  ///< why it could not be fitted; it has no weight then
};

struct Transfer {
  Regressor model;                  ///< of the target
  std::vector<TransferPart> parts;  ///< what it is made of
  /// Of the source's function and the target's, posterior mean and standard deviation in the
  /// coregionalised model; where the source is no Gaussian process, the plain correlation of its
  /// predictions with the target rows, without deviation. NaN where not known: without rows, or
  /// where the coregionalised model cannot be fitted.
  double correlation = std::numeric_limits<double>::quiet_NaN();
  double correlation_deviation = std::numeric_limits<double>::quiet_NaN();
};

/// `source` fitted to `source_rows`. No target rows: the source itself. Throws InputError as
/// check(TrainingSet), naming an input that is not the same in both, for source_basis and
/// coregionalised where the source is no Gaussian process of the response itself, where a method
/// needs more target rows, and on weights where it takes none: all ways from a Gaussian process
/// but shift_and_scale.
Transfer transfer(const PretrainedModel& source, const TrainingSet& source_rows,
                  const TrainingSet& target, const TransferOptions& options = {});

/// Rows of both, first a's; points of a and b are different ones. Groups where both have them;
/// weights where one has them, 1 for the other's rows.
TrainingSet joined(const TrainingSet& a, const TrainingSet& b);

/// Which `count` rows of `candidates` (m x d) to simulate first, in order: each leaves the smallest
/// mean variance of the target's function over all candidates, before anything is known of how it
/// relates to the source but `simulated` (p x d; no rows: nothing). O((1024 d + p + count)(p +
/// m)^2) and some four matrices of p + m rows. Throws InputError on more rows than there are, and
/// on more than 2,000 candidates and simulated rows together.
std::vector<Eigen::Index> first_target_runs(const GaussianProcess& source, const Matrix& candidates,
                                            Eigen::Index count, const Matrix& simulated = {});
/// The same where the source may be of any kind: by a Gaussian process of its rows if it is none of
/// the response itself.
std::vector<Eigen::Index> first_target_runs(const PretrainedModel& source,
                                            const TrainingSet& source_rows,
                                            const Matrix& candidates, Eigen::Index count,
                                            const Matrix& simulated = {});

}  // namespace repose::surrogate
