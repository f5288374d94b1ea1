// A fitted model on disk; a loaded model predicts the same bits.
//
// One HDF5 file of tables (see repose/table/io.hpp), readable without repose:
//   /            attributes: repose_model "gaussian-process", model_version 1, response, kernel,
//   noise, basis,
//                estimator; shift and scale of y = shift + scale * standardised; amplitude (process
//                variance / scale^2), noise_ratio, jitter, within; how the fit went
//   /inputs      a row an input: name, lower, upper (declared range), length_scale (in units of the
//   range) /points      a row a different point: u1 ... ud in units of the range, y (mean,
//   standardised), count /rows        a row an observation: point (index, from 0), y (standardised)
//   /factor      l: lower Cholesky factor of R + noise_ratio diag(1/count) + jitter I, packed by
//   columns /parameters  what the fit searched for, where it did
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// A model with the names that give its numbers a meaning.
struct NamedModel {
  GaussianProcess model;
  std::vector<std::string> inputs;  ///< columns of x, in order
  std::string response;
};

/// Writes one file, atomically. Throws InputError where names do not match the model's dimension,
/// StorageError.
void save_model(const std::filesystem::path& path, const NamedModel& model);

/// Throws StorageError where the file is missing, damaged, no model or of a newer version, naming
/// it.
NamedModel load_model(const std::filesystem::path& path);

}  // namespace repose::surrogate
