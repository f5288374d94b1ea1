// Compiled with -march=x86-64-v3 where the compiler knows it. Everything here is inlined into one
// function: an inline function that the linker could share with other files would crash older
// processors. A test looks for such symbols.
#include "contact/pair_kernel_lanes.hpp"

namespace repose::dem {

#ifdef __AVX2__
namespace {

void add_forces(const PairBatch& batch, DeepestPair& deepest) {
  detail::add_forces<detail::Pack<4>>(batch, deepest);
}
void find_forces(const WallBatch& batch) {
  detail::find_forces<detail::Pack<4>>(batch);
}

constexpr PairKernel kKernel{"x86-64-v3", add_forces, find_forces};

}  // namespace

const PairKernel* pair_kernel_v3() {
  return &kKernel;
}
#else
const PairKernel* pair_kernel_v3() {
  return nullptr;
}
#endif

}  // namespace repose::dem
