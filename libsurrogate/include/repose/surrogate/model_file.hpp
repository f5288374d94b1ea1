// A fitted model on disk; a loaded model predicts the same bits.
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

/// Writes one HDF5 file, atomically: /model (attributes: format, version, kernel, options, fit),
/// /data (training columns), /parameters, /factor. Throws InputError where names do not match the
/// model's dimension, StorageError.
void save_model(const std::filesystem::path& path, const NamedModel& model);

/// Throws StorageError where the file is missing, damaged or of a newer format, naming it.
NamedModel load_model(const std::filesystem::path& path);

}  // namespace repose::surrogate
