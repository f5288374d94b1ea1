// What a linear model holds; shared by its implementation and by model files.
#pragma once

#include "linear_terms.hpp"

namespace repose::surrogate {

struct LinearModel::State {
  CodedColumns columns = {};
  LinearMethod method = LinearMethod::least_squares;
  std::vector<doe::Term> terms = {};
  Vector coefficients = {};
  Matrix row_space = {};  ///< p x rank, orthonormal; empty where the rank is p
  Matrix root = {};       ///< p x rank: the coefficients' covariance is coefficient_variance R R^T
  double coefficient_variance = 0.0;
  double error_variance = 0.0;
  LinearFitReport report = {};

  Matrix design(const Matrix& natural) const {
    return doe::model_matrix(columns.coded(natural), terms);
  }
};

struct LinearModelAccess {
  using State = LinearModel::State;
  static const State& state(const LinearModel& model) { return *model.state_; }
  static LinearModel make(State state) {
    return LinearModel(std::make_shared<const State>(std::move(state)));
  }
};

}  // namespace repose::surrogate
