#include "contact/pair_kernel_lanes.hpp"
#include "parallel/exact_sum.hpp"

namespace repose::dem {
namespace {

template <class R>
void add_forces(const PairBatch& batch, DeepestPair& deepest) {
  detail::add_forces<R>(batch, deepest);
}
template <class R>
void find_forces(const WallBatch& batch) {
  detail::find_forces<R>(batch);
}

constexpr PairKernel kScalar{"scalar", add_forces<double>, find_forces<double>};
constexpr PairKernel kBaseline{"x86-64", add_forces<detail::Pack<2>>, find_forces<detail::Pack<2>>};

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

void add_forces_with_energies(const PairBatch& batch, DeepestPair& deepest, ExactEnergies& sum) {
  detail::add_batch<double>(batch, deepest, sum);
}

void find_forces_with_energies(const WallBatch& batch, ExactEnergies& sum) {
  detail::find_batch<double>(batch, sum);
}

}  // namespace repose::dem
