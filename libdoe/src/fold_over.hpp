// The fold-over structure of a design: which runs are mirror images of each other.
#pragma once

#include <utility>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

struct FoldOver {
  std::vector<std::pair<int, int>> pairs;
  std::vector<int> centre_runs;
  std::vector<int> orphans;
};

/// Every run belongs to exactly one of the three; of several possible partners the first is taken.
/// Levels within 1e-9 of each other count as equal.
FoldOver find_fold_over(const Matrix& coded);

}  // namespace repose::doe
