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

std::vector<const PairKernel*> usable_pair_kernels() {
  std::vector<const PairKernel*> kernels{&kScalar, &kBaseline};
#if defined(__x86_64__)
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  if (v3 && pair_kernel_v3() != nullptr) kernels.push_back(pair_kernel_v3());
  const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  if (v4 && pair_kernel_v4() != nullptr) kernels.push_back(pair_kernel_v4());
#endif
  return kernels;
}

const PairKernel& pair_kernel() {
  static const PairKernel* const widest = usable_pair_kernels().back();
  return *widest;
}

void add_forces_with_energies(const PairBatch& batch, DeepestPair& deepest, ContactEnergies& sum) {
  detail::add_batch<double>(batch, deepest, sum);
}

}  // namespace repose::dem
