#include "contact/pair_kernel_lanes.hpp"

namespace repose::dem {
namespace {

void add_forces_scalar(const PairBatch& batch, DeepestPair& deepest) {
  NoEnergies none;
  detail::add_batch<double>(batch, deepest, none);
}
void add_forces_baseline(const PairBatch& batch, DeepestPair& deepest) {
  NoEnergies none;
  detail::add_batch<detail::Pack<2>>(batch, deepest, none);
}

constexpr PairKernel kScalar{"scalar", add_forces_scalar};
constexpr PairKernel kBaseline{"x86-64", add_forces_baseline};

}  // namespace

const PairKernel& pair_kernel_scalar() {
  return kScalar;
}
const PairKernel& pair_kernel_baseline() {
  return kBaseline;
}

const PairKernel* usable_pair_kernel_v3() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2"))
    return pair_kernel_v3();
#endif
  return nullptr;
}

const PairKernel& pair_kernel() {
  static const PairKernel* const v3 = usable_pair_kernel_v3();
  return v3 != nullptr ? *v3 : kBaseline;
}

void add_forces_with_energies(const PairBatch& batch, DeepestPair& deepest, ContactEnergies& sum) {
  detail::add_batch<double>(batch, deepest, sum);
}

}  // namespace repose::dem
