// The columns of a linear model: coded inputs and their products.
#pragma once

#include <string>
#include <vector>

#include "encoding.hpp"
#include "repose/doe/model_terms.hpp"
#include "repose/surrogate/linear_model.hpp"

namespace repose::surrogate {

/// Inputs in natural units as columns in [-1, 1] (numbers, labels) or of 0 and 1 (levels but the
/// first).
class CodedColumns {
 public:
  CodedColumns() = default;
  explicit CodedColumns(std::vector<Input> inputs);

  const Encoding& encoding() const { return encoding_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(coordinate_.size()); }
  /// m x count() from m x d; throws as Encoding::encode.
  Matrix coded(const Matrix& natural) const;
  /// All terms; products of two levels of one category, which are 0, left out.
  std::vector<doe::Term> terms(LinearTerms which) const;
  /// "mu_s", "layering=mixed".
  std::vector<std::string> names(const std::vector<std::string>& inputs) const;

 private:
  Encoding encoding_;
  std::vector<Eigen::Index> coordinate_;  // of the encoding, for each column
};

}  // namespace repose::surrogate
