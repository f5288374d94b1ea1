#define REPOSE_DENSE_NAME "x86-64"
#include "dense_kernels.hpp"

namespace repose::surrogate {

const Dense& dense_baseline() {
  return kDense;
}

const Dense& dense() {
  static const Dense& chosen = []() -> const Dense& {
#if defined(__x86_64__)
    const bool has_v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    if (has_v3 && dense_v3() != nullptr) return *dense_v3();
#endif
    return dense_baseline();
  }();
  return chosen;
}

}  // namespace repose::surrogate
