#include "model_kinds.hpp"

#include <array>

namespace repose::surrogate {

std::span<const ModelKind> model_kinds() {
  static constexpr std::array kKinds{
      ModelKind{"gaussian-process", 3, write_gaussian_process, read_gaussian_process},
  };
  return kKinds;
}

}  // namespace repose::surrogate
