// Compiled for a processor with AVX2, for which Eigen by itself aligns and frees its memory
// otherwise.
#include "repose/base/parameter_space.hpp"
#include "repose/doe/space_filling.hpp"

bool is_safe_with_other_alignment() {
#ifdef __AVX2__
  if (!__builtin_cpu_supports("avx2")) return true;
#endif
  using namespace repose;
  const ParameterSpace space({{.name = "a"}, {.name = "b"}, {.name = "c"}});
  bool is_same = true;
  for (int points = 1; points < 40; ++points) {
    Matrix unit =
        doe::latin_hypercube(points, 3, {.iterations = 0});  // allocated there, freed here
    unit = space.from_unit_rows(Matrix(unit)) - Matrix::Zero(points, 3);
    unit.conservativeResize(points + 1, 3);
    unit.row(points).setConstant(0.5);
    is_same = is_same && space.from_unit_rows(unit) == unit;
  }
  return is_same;
}
