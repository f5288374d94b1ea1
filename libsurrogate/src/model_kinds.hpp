// The kinds of models that files can hold.
//
// A new kind needs: a source with write_NAME and read_NAME, their declarations here, and a line in
// model_kinds.cpp. A change of what is written raises the version; what older versions lack,
// read_NAME supplies.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "model_content.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {

struct ModelKind {
  const char* name;  ///< attribute repose_model
  std::int64_t version;
  /// The content if the model is of this kind.
  std::optional<ModelContent> (*write)(const Regressor& model);
  Regressor (*read)(const ModelReader& file, std::vector<Input> inputs);
};
std::span<const ModelKind> model_kinds();

/// Of a model of any kind, with the attributes repose_model and model_version. Throws InputError
/// for a model that is none of ours.
ModelContent content_of(const Regressor& model);
/// The model that content_of() was given; a model file, or a part of one.
Regressor read_content(const ModelReader& file, std::vector<Input> inputs);
/// Damage where the kind or its version is not known.
const ModelKind& kind_of(const ModelReader& file);

std::optional<ModelContent> write_gaussian_process(const Regressor& model);
Regressor read_gaussian_process(const ModelReader& file, std::vector<Input> inputs);
std::optional<ModelContent> write_tree(const Regressor& model);
Regressor read_tree(const ModelReader& file, std::vector<Input> inputs);
std::optional<ModelContent> write_bagged_trees(const Regressor& model);
Regressor read_bagged_trees(const ModelReader& file, std::vector<Input> inputs);
std::optional<ModelContent> write_boosted_trees(const Regressor& model);
Regressor read_boosted_trees(const ModelReader& file, std::vector<Input> inputs);

std::optional<ModelContent> write_linear_model(const Regressor& model);
Regressor read_linear_model(const ModelReader& file, std::vector<Input> inputs);

std::optional<ModelContent> write_perceptron(const Regressor& model);
Regressor read_perceptron(const ModelReader& file, std::vector<Input> inputs);

std::optional<ModelContent> write_svr(const Regressor& model);
Regressor read_svr(const ModelReader& file, std::vector<Input> inputs);

std::optional<ModelContent> write_transferred(const Regressor& model);
Regressor read_transferred(const ModelReader& file, std::vector<Input> inputs);

}  // namespace repose::surrogate
