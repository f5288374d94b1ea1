#include "model_kinds.hpp"

#include <array>

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
  };
  return kKinds;
}

}  // namespace repose::surrogate
