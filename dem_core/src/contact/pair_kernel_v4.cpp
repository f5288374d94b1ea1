// As pair_kernel_v3.cpp, with -march=x86-64-v4: eight contacts side by side.
#include "contact/pair_kernel_lanes.hpp"

namespace repose::dem {

#ifdef __AVX512F__
namespace {

void add_forces(const PairBatch& batch, DeepestPair& deepest) {
  detail::add_forces<detail::Pack<8>>(batch, deepest);
}
void find_forces(const WallBatch& batch) {
  detail::find_forces<detail::Pack<8>>(batch);
}

constexpr PairKernel kKernel{"x86-64-v4", add_forces, find_forces};

}  // namespace

const PairKernel* pair_kernel_v4() {
  return &kKernel;
}
#else
const PairKernel* pair_kernel_v4() {
  return nullptr;
}
#endif

}  // namespace repose::dem
