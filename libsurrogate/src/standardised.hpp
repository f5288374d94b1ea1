// Coordinates with mean 0 and deviation 1 over the training rows.
#pragma once

#include <vector>

#include "encoding.hpp"
#include "repose/surrogate/training_set.hpp"

namespace repose::surrogate {

/// z = (u - shift) factor of the encoded coordinates u. What the training rows do not vary, a level
/// they do not have too, has the factor 0: it says nothing.
class StandardisedColumns {
 public:
  StandardisedColumns() = default;
  /// Shifts and factors of the training rows (weights, which may be empty, count in proportion), or
  /// none: z = u.
  static StandardisedColumns of(const TrainingSet& data);
  static StandardisedColumns none(const std::vector<Input>& inputs);
  StandardisedColumns(std::vector<Input> inputs, Vector shift, Vector factor);

  const std::vector<Input>& inputs() const { return encoding_.inputs(); }
  Eigen::Index count() const { return shift_.size(); }
  const Vector& shift() const { return shift_; }
  const Vector& factor() const { return factor_; }
  /// m x count() from m x d; throws as Encoding::encode.
  Matrix columns(const Matrix& natural) const;

 private:
  Encoding encoding_;
  Vector shift_;
  Vector factor_;
};

}  // namespace repose::surrogate
