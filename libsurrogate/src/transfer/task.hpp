// One source and one target to transfer to, by any method; for transfer() and its validation.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "parts.hpp"
#include "repose/surrogate/coregionalised_process.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {

/// The process of a source that the closed forms can use: of the response itself; else nullptr.
const GaussianProcess* process_of(const PretrainedModel& source);

/// What several methods share, and the correlation, is computed once. Not for several threads;
/// refers to its arguments.
class TransferTask {
 public:
  /// Throws as transfer(). `methods`: those that will be asked for.
  TransferTask(const PretrainedModel& source, const TrainingSet& source_rows,
               const TrainingSet& target, std::span<const TransferMethod> methods,
               std::uint64_t seed);
  Transfer by(TransferMethod method);

 private:
  Regressor fit(TransferMethod method, const TrainingSet& target);
  Regressor target_alone(const TrainingSet& target) const;
  Vector left_out(TransferMethod method);
  void judge(TransferPart& part, TransferredModel& model);
  TransferredModel combine(std::vector<TransferPart>& parts);
  const CoregionalisedProcess::Judged& coregionalised();
  Gaussian correlation();

  const PretrainedModel& source_;
  const TrainingSet& source_rows_;
  const TrainingSet& target_;
  std::uint64_t seed_;
  std::vector<Fold> folds_;            ///< of the target's points, where methods are weighed
  std::vector<Eigen::Index> fold_of_;  ///< its rows
  std::optional<CoregionalisedProcess::Judged> coregionalised_;
  std::optional<Gaussian> correlation_;
};

}  // namespace repose::surrogate
