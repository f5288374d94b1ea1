// What a support vector regression holds; shared by its implementation and by model files.
#pragma once

#include "repose/surrogate/support_vector_regression.hpp"
#include "standardised.hpp"

namespace repose::surrogate {

/// y = shift + scale (sum_i weight_i k(s_i, z/kernel_scale) + offset).
struct SupportVectorRegression::State {
  StandardisedColumns columns = {};
  SvrKernel kernel = SvrKernel::gaussian;
  double kernel_scale = 1.0;  ///< in units of the columns
  double shift = 0.0;
  double scale = 1.0;
  double offset = 0.0;
  Matrix vectors = {};  ///< s x p, columns divided by the kernel scale
  Vector weights = {};
};

struct SvrAccess {
  using State = SupportVectorRegression::State;
  static const State& state(const SupportVectorRegression& model) { return *model.state_; }
  static SupportVectorRegression make(State state) {
    return SupportVectorRegression(std::make_shared<const State>(std::move(state)));
  }
};

}  // namespace repose::surrogate
