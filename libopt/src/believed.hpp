// The surrogates as they are believed to be after the points chosen so far.
#pragma once

#include <span>
#include <vector>

#include "goal.hpp"
#include "repose/opt/propose.hpp"

namespace repose::opt {

using Predictions = std::vector<Gaussian>;  ///< one of each surrogate, at one point

class BelievedModels {
 public:
  BelievedModels(std::span<const Surrogate> models, const Goal& goal, const FeasibleSet& set,
                 const ProposeOptions& options);

  /// Visited points, pending ones and those chosen so far.
  const Matrix& known() const { return known_; }
  /// Those of them that belong to the set: only they can be improved upon.
  const Matrix& incumbents() const { return incumbents_; }
  std::span<const Surrogate> models() const { return models_; }
  Predictions predict(const Vector& x) const;
  /// By row.
  std::vector<Predictions> predict_rows(const Matrix& rows) const;
  /// Takes what ProposeOptions::belief says for the values at x.
  void believe(const Vector& x);

 private:
  void append(const Matrix& rows);

  std::vector<Surrogate> models_;
  const FeasibleSet& set_;
  Matrix known_;
  Matrix incumbents_;
  std::vector<double> lie_;  ///< of each model; empty: its posterior mean
  unsigned threads_;
};

/// Whether x obeys the constraints and its whole coordinates are whole, up to rounding.
bool belongs_to(const FeasibleSet& set, const Vector& x);
/// The rows that do.
Matrix rows_in(const FeasibleSet& set, const Matrix& rows);

/// `values` by size, the smallest first; not a number last.
std::vector<Eigen::Index> ascending(const std::vector<double>& values);

}  // namespace repose::opt
