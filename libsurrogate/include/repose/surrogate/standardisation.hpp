// How models that measure distances between inputs scale them.
#pragma once

namespace repose::surrogate {

enum class Standardisation {
  none,               ///< inputs scaled by their declared range to [0, 1]
  standard_deviation  ///< and then to mean 0 and deviation 1 over the training rows
};

}  // namespace repose::surrogate
