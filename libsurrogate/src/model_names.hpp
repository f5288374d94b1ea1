// Words and version of model files, for their writer and their reader.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <string>

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate::model_names {

inline constexpr const char* kModel = "gaussian-process";
inline constexpr std::int64_t kVersion = 3;
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
inline constexpr std::array kCodings{Coding::label, Coding::one_hot, Coding::exchangeable};

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

}  // namespace repose::surrogate::model_names
