#include "model_kinds.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "gaussian_process_file.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {

std::span<const ModelKind> model_kinds() {
  static constexpr std::array kKinds{
      ModelKind{"gaussian-process", 3, write_gaussian_process, read_gaussian_process},
      ModelKind{"linear-model", 1, write_linear_model, read_linear_model},
      ModelKind{"perceptron", 1, write_perceptron, read_perceptron},
      ModelKind{"support-vector-regression", 1, write_svr, read_svr},
      ModelKind{"tree", 1, write_tree, read_tree},
      ModelKind{"bagged-trees", 1, write_bagged_trees, read_bagged_trees},
      ModelKind{"boosted-trees", 2, write_boosted_trees, read_boosted_trees},
      ModelKind{"transferred", 1, write_transferred, read_transferred},
  };
  return kKinds;
}

ModelContent content_of(const Regressor& model) {
  for (const ModelKind& kind : model_kinds())
    if (std::optional<ModelContent> content = kind.write(model)) {
      content->attributes["repose_model"] = std::string(kind.name);
      content->attributes["model_version"] = kind.version;
      return std::move(*content);
    }
  throw InputError(
      fmt::format("there is no file format for this kind of model ({}); it cannot be "
                  "written",
                  model.describe()));
}

const ModelKind& kind_of(const ModelReader& file) {
  if (!file.has("repose_model")) file.damaged("it holds no model");
  std::vector<std::string> names;
  for (const ModelKind& kind : model_kinds()) {
    names.emplace_back(kind.name);
    if (file.kind() != kind.name) continue;
    if (file.version() < 1 || file.version() > kind.version)
      file.damaged(fmt::format("its version is {}, this program reads 1 to {}", file.version(),
                               kind.version));
    return kind;
  }
  file.damaged(fmt::format("it holds a model of the kind '{}'; this program knows {}", file.kind(),
                           fmt::join(names, ", ")));
}

Regressor read_content(const ModelReader& file, std::vector<Input> inputs) {
  const ModelKind& kind = kind_of(file);
  if (kind.read == read_gaussian_process) check_functions(file, {});
  return kind.read(file, std::move(inputs));
}

}  // namespace repose::surrogate
