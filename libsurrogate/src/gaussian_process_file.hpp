// Words of the model files of Gaussian processes, for their writer and their reader.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>

#include "model_content.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// A file holds no code: throws InputError unless these are the functions of the fitted model.
void check_functions(const ModelReader& file, const BasisFunctions& functions);
GaussianProcess read_process(const ModelReader& file, std::vector<Input> inputs,
                             BasisFunctions functions);

namespace model_names {

inline constexpr std::array kTerminations{opt::Termination::converged, opt::Termination::budget,
                                          opt::Termination::round_off, opt::Termination::failed};
inline constexpr std::array kStates{ParameterState::converged, ParameterState::at_lower_bound,
                                    ParameterState::at_upper_bound, ParameterState::inert,
                                    ParameterState::fixed};
inline constexpr std::array kNoises{Noise::none, Noise::estimated, Noise::known, Noise::by_point};
inline constexpr std::array kBases{Basis::none, Basis::constant, Basis::linear, Basis::quadratic};
inline constexpr std::array kEstimators{Estimator::ml, Estimator::reml, Estimator::loo};
inline constexpr std::array kScales{ResponseScale::linear, ResponseScale::log,
                                    ResponseScale::logit};

/// "x1" ... inputs in natural units, "u1" ... encoded.
inline std::string natural_column(Eigen::Index k) {
  return fmt::format("x{}", k + 1);
}
inline std::string encoded_column(Eigen::Index k) {
  return fmt::format("u{}", k + 1);
}
inline std::string root_column(Eigen::Index k) {
  return fmt::format("root{}", k + 1);
}

}  // namespace model_names
}  // namespace repose::surrogate
