// The words by which options are known on command lines and in files.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "repose/base/error.hpp"
#include "repose/surrogate/fit_report.hpp"
#include "repose/surrogate/gaussian_process_options.hpp"
#include "repose/surrogate/input.hpp"

namespace repose::surrogate {
namespace {

constexpr std::array kCorrelations{
    "exponential",           "matern32",           "matern52",
    "squared-exponential",   "rational-quadratic", "ard-exponential",
    "ard-matern32",          "ard-matern52",       "ard-squared-exponential",
    "ard-rational-quadratic"};
constexpr std::array kBases{"none", "constant", "linear", "quadratic"};

template <class Enum, std::size_t N>
const char* name(const char* const (&names)[N], Enum value) {
  return names[static_cast<std::size_t>(value)];
}

}  // namespace

const char* to_string(ParameterUncertainty uncertainty) {
  constexpr const char* kNames[] = {"ignored", "first-order"};
  return name(kNames, uncertainty);
}

const char* to_string(Kernel kernel) {
  const std::size_t offset = kernel.length_scales == LengthScales::shared ? 0 : 5;
  return kCorrelations[offset + static_cast<std::size_t>(kernel.correlation)];
}

const std::vector<Kernel>& all_kernels() {
  static const std::vector<Kernel> kernels = [] {
    std::vector<Kernel> all;
    for (const LengthScales scales : {LengthScales::shared, LengthScales::one_per_input})
      for (int c = 0; c < 5; ++c) all.push_back({static_cast<Correlation>(c), scales});
    return all;
  }();
  return kernels;
}

Kernel kernel_named(std::string_view wanted) {
  for (const Kernel kernel : all_kernels())
    if (wanted == to_string(kernel)) return kernel;
  throw InputError(fmt::format("kernel '{}' is not known; choose one of {}", wanted,
                               fmt::join(kCorrelations, ", ")));
}

Basis basis_named(std::string_view wanted) {
  for (std::size_t i = 0; i < kBases.size(); ++i)
    if (wanted == kBases[i]) return static_cast<Basis>(i);
  throw InputError(
      fmt::format("basis '{}' is not known; choose one of {}", wanted, fmt::join(kBases, ", ")));
}

const char* to_string(Basis basis) {
  return kBases[static_cast<std::size_t>(basis)];
}
const char* to_string(Noise noise) {
  return name({"none", "estimated", "known", "by-point"}, noise);
}
const char* to_string(Estimator estimator) {
  return name({"ml", "reml", "loo"}, estimator);
}
const char* to_string(ResponseScale scale) {
  return name({"linear", "log", "logit"}, scale);
}
const char* to_string(Coding coding) {
  return name({"label", "one-hot", "exchangeable"}, coding);
}
const char* to_string(ParameterState state) {
  return name({"converged", "at_lower_bound", "at_upper_bound", "inert", "fixed"}, state);
}

}  // namespace repose::surrogate
