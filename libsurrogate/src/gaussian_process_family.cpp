// The settings of a Gaussian process that the thesis searched as a black box.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encoding.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/settings_search.hpp"
#include "response.hpp"

namespace repose::surrogate {
namespace {

constexpr Basis kBases[] = {Basis::constant, Basis::none, Basis::linear, Basis::quadratic};

/// Places of the settings.
enum Place : Eigen::Index { kKernel, kBasis, kSigma, kScale, kStandardise };

/// The values whose distances count: logarithms on a log scale.
Vector modelled_column(const TrainingSet& data, Eigen::Index k) {
  const Input& input = data.inputs[static_cast<std::size_t>(k)];
  if (input.is_categorical() || input.scale == Scale::linear) return data.x.col(k);
  return data.x.col(k).array().log();
}

double deviation(const Vector& values) {
  const double mean = values.mean();
  return std::sqrt((values.array() - mean).square().sum() /
                   static_cast<double>(std::max<Eigen::Index>(values.size() - 1, 1)));
}

double largest_range(const TrainingSet& data) {
  double range = 0.0;
  for (Eigen::Index k = 0; k < data.x.cols(); ++k) {
    const Vector u = modelled_column(data, k);
    range = std::max(range, u.maxCoeff() - u.minCoeff());
  }
  if (!(range > 0.0)) throw InputError("every input is constant; nothing can be learnt");
  return range;
}

ParameterSpace space_of(const TrainingSet& data, ResponseScale scale) {
  std::vector<std::string> kernels, bases;
  for (const Kernel kernel : all_kernels()) kernels.emplace_back(to_string(kernel));
  for (const Basis basis : kBases) bases.emplace_back(to_string(basis));
  Vector y = data.y;
  for (double& value : y) value = modelled(scale, value);
  if (!y.allFinite())
    throw InputError(fmt::format("a response is not allowed on a {} scale", to_string(scale)));
  const double range = largest_range(data);
  return ParameterSpace(
      {{.name = "kernel", .kind = ParameterKind::categorical, .categories = kernels},
       {.name = "basis", .kind = ParameterKind::categorical, .categories = bases},
       {.name = "sigma",
        .lower = 1e-4,
        .upper = std::max(1e-3, 10.0 * deviation(y)),
        .scale = Scale::log},
       {.name = "kernel_scale", .lower = 1e-3 * range, .upper = range, .scale = Scale::log},
       {.name = "standardise",
        .kind = ParameterKind::categorical,
        .categories = {"false", "true"}}});
}

/// Of an input that is a number: what counts as a distance of 1.
double unit_of(const TrainingSet& data, Eigen::Index k, const Vector& settings) {
  if (settings[kStandardise] != 1.0) return 1.0;
  const double sd = deviation(modelled_column(data, k));
  return sd > 0.0 ? sd : 1.0;
}

/// A shared length scale as one for each input, each held fixed: the same model over the inputs as
/// they are declared, however they were scaled.
void fix_length_scales(const TrainingSet& data, const Vector& settings,
                       GaussianProcessOptions& options) {
  options.kernel.length_scales = LengthScales::one_per_input;
  const Encoding encoding(data.inputs, LengthScales::one_per_input);
  for (Eigen::Index c = 0; c < encoding.coordinates(); ++c) {
    const Eigen::Index s = encoding.scale_of(c);
    if (c > 0 && encoding.scale_of(c - 1) == s) continue;
    const Eigen::Index k = encoding.input_of(c);
    const double value =
        settings[kScale] * (data.inputs[static_cast<std::size_t>(k)].is_categorical()
                                ? encoding.scale_units()[s]
                                : unit_of(data, k, settings));
    options.bounds.push_back({encoding.scale_names()[static_cast<std::size_t>(s)], value, value});
  }
}

Regressor fitted(const TrainingSet& data, const Vector& settings, GaussianProcessOptions options) {
  const double variance = settings[kSigma] * settings[kSigma];
  options.kernel = all_kernels()[static_cast<std::size_t>(settings[kKernel])];
  options.basis = kBases[static_cast<std::size_t>(settings[kBasis])];
  options.bounds = {{"noise_variance", variance, variance}};
  if (options.kernel.length_scales == LengthScales::shared)
    fix_length_scales(data, settings, options);
  const std::uint64_t seed = options.seed;
  return gaussian_process_trainer("Gaussian process", options).fit(data, seed);
}

}  // namespace

ModelFamily gaussian_process_family(const GaussianProcessOptions& options) {
  GaussianProcessOptions o = options;
  o.noise = Noise::estimated;
  o.estimator = Estimator::ml;
  o.prior = Prior::none;
  o.parameter_uncertainty = ParameterUncertainty::ignored;
  return {.name = "Gaussian process",
          .space =
              [scale = o.response_scale](const TrainingSet& data) { return space_of(data, scale); },
          .trainer =
              [o](const Vector& settings) {
                return Trainer{"Gaussian process",
                               [o, settings](const TrainingSet& data, std::uint64_t) {
                                 return fitted(data, settings, o);
                               }};
              }};
}

}  // namespace repose::surrogate
