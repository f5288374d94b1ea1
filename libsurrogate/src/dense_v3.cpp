// Compiled with -march=x86-64-v3 where the compiler knows it. Eigen goes by another name here: its
// inline functions would else be shared with other files by the linker and crash older processors.
// A test looks for symbols that could be.
#ifdef __AVX2__
#define Eigen EigenV3
#define REPOSE_DENSE_NAME "x86-64-v3"
#include "dense_kernels.hpp"

namespace repose::surrogate {
const Dense* dense_v3() {
  return &kDense;
}
}  // namespace repose::surrogate

#else
#include "dense.hpp"

namespace repose::surrogate {
const Dense* dense_v3() {
  return nullptr;
}
}  // namespace repose::surrogate
#endif
