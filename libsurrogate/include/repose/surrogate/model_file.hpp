// A fitted model on disk; a loaded model predicts the same bits.
//
// One HDF5 file of tables (see repose/table/io.hpp), readable without repose. All kinds:
//   /              attributes: repose_model (the kind), model_version (of the kind), response
//   /inputs        a row an input: name, lower, upper, scale, levels (their number), coding
//   /levels        of the categories: input, level
//
// "gaussian-process", version 3:
//   /              attributes: response_scale, kernel, alpha, noise, basis, estimator; shift and
//                  scale of modelled y = shift + scale * standardised; amplitude (process
//                  variance/scale^2), noise_ratio, jitter, within, log_repeats, log_jacobian;
//                  variance_factor of amplitude and noise in predictions, uncertain_directions; how
//                  the fit went
//   /length_scales name, length_scale (in units of the coordinates u)
//   /points        a row a different point: x1 ... xd in natural units, u1 ... up encoded, y (mean,
//                  standardised), noise (weight v of its mean)
//   /rows          a row an observation: point (index, from 0), y (standardised), noise (weight w)
//   /factor        l: lower Cholesky factor of R + noise_ratio diag(v) + jitter I, by columns
//   /parameter_uncertainty
//                  root1 ...: B, so that the log parameters have the covariance B B^T; a row each:
//                  length scales, alpha of the rational quadratic, noise ratio
//   /trend         regression functions and their coefficients; /functions those of the user
//   /parameters    what the fit searched for
// Versions 1 and 2, which lack variance_factor and /parameter_uncertainty, are read too.
//
// "linear-model", version 1:
//   /              method, error_variance and coefficient_variance (where known), rank,
//                  residual_df, iterations, converged
//   /terms         first, second (coded columns from 0, equal for a main effect; -1: the constant),
//                  coefficient
//   /root          values, by columns: R (coefficients x rank), coefficient_variance R R^T is the
//                  coefficients' covariance; /row_space where rank < coefficients: V, likewise
//
// "support-vector-regression", version 1, and "perceptron", version 1:
//   /columns       a row a coordinate: z = (u - shift) factor
//   /              kernel, kernel_scale, shift, scale, offset; y = shift + scale (sum weight k +
//                  offset). support_vectors: their number; /support_vectors: u1 ... up (divided by
//                  kernel_scale), weight
//   /              shift, scale; y = shift + scale * mean of the networks. networks: their number;
//                  /layers: neurons; /parameters: network1 ... (W by columns, b, layer by layer);
//                  /training
//
// "tree", "bagged-trees", "boosted-trees", version 1:
//   /              minimum_leaf, maximum_splits, maximum_depth, predictors (0: no limit);
//                  of ensembles seed; of bags points, out_of_bag_rows, _rmse, _q2; of boosting
//                  constant, learning_rate and how it was stopped. A prediction is the leaf's mean;
//                  of a bag the mean over trees; of boosting constant + learning_rate * their sum
//   /trees         a row a tree: root (node, from 0), depth
//   /nodes         input (from 0; -1: a leaf), threshold (a number below it goes left), level_set
//                  (row of /level_sets that stands for a category's first level, else -1), left
//                  (the other child is the next node; a leaf's is itself), mean
//   /level_sets    left: 1 if the level goes left
//   /leaf_errors   of bags, a row a node: squares and number of errors of rows out of bag
//   /out_of_bag    of bags, a row an observation: predicted, known (0: in every bag)
//   /held_out      of boosting: rmse with 0, 1, ... trees
//
// "transferred", version 1:
//   /              correlation, correlation_deviation (where known)
//   /parts         method, weight
// and, as the attributes source.NAME, part1.NAME, ... and the tables below /source, /part1, ...:
// the source, a model of any kind, and each part, by its method:
//   retrained, target-only: a model of any kind; source-basis: a Gaussian process
//   shift-and-scale: shift, scale, residual_variance, noise_variance; /coefficients: covariance of
//                  shift and scale
//   coregionalised: /points: x1 ..., y; /relations: correlation, scale, own_variance,
//                  shift_deviation, noise_variance, weight, length_factor1 ...
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// A model of any kind with the names that give its numbers a meaning.
struct NamedRegressor {
  Regressor model;
  std::vector<std::string> inputs;  ///< columns of x, in order
  std::string response;
};

/// Writes one file, atomically. Throws InputError where names do not match the model's dimension
/// and for a model that is none of ours, StorageError.
void save_regressor(const std::filesystem::path& path, const NamedRegressor& model);

/// Throws StorageError where the file is missing, damaged, no model, of an unknown kind or of a
/// newer version, naming it; InputError for a Gaussian process with regression functions of the
/// user, which load_model() reads.
NamedRegressor load_regressor(const std::filesystem::path& path);

/// For what only a Gaussian process can do.
struct NamedModel {
  GaussianProcess model;
  std::vector<std::string> inputs;
  std::string response;
};
void save_model(const std::filesystem::path& path, const NamedModel& model);

/// As load_regressor(); throws InputError where the file holds another kind of model. Regression
/// functions of the user are code and must be given again, with the names that the file has; else
/// InputError.
NamedModel load_model(const std::filesystem::path& path, const BasisFunctions& functions = {});

}  // namespace repose::surrogate
