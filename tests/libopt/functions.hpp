// Benchmark functions with known optima.
#pragma once

#include <cmath>
#include <numbers>

#include "repose/opt/objective.hpp"

namespace repose::opt::test {

struct Benchmark {
  const char* name;
  double (*value)(const Vector& x);
  Bounds bounds;
  double minimum;
};

inline double branin(const Vector& x) {
  using std::numbers::pi;
  const double a = x[1] - 5.1 * x[0] * x[0] / (4.0 * pi * pi) + 5.0 * x[0] / pi - 6.0;
  return a * a + 10.0 * (1.0 - 1.0 / (8.0 * pi)) * std::cos(x[0]) + 10.0;
}

/// Dixon & Szegoe 1978.
inline double hartmann6(const Vector& x) {
  constexpr double kAlpha[4] = {1.0, 1.2, 3.0, 3.2};
  constexpr double kA[4][6] = {{10, 3, 17, 3.5, 1.7, 8},
                               {0.05, 10, 17, 0.1, 8, 14},
                               {3, 3.5, 1.7, 10, 17, 8},
                               {17, 8, 0.05, 10, 0.1, 14}};
  constexpr double kP[4][6] = {{1312, 1696, 5569, 124, 8283, 5886},
                               {2329, 4135, 8307, 3736, 1004, 9991},
                               {2348, 1451, 3522, 2883, 3047, 6650},
                               {4047, 8828, 8732, 5743, 1091, 381}};
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    double exponent = 0.0;
    for (int j = 0; j < 6; ++j) exponent += kA[i][j] * std::pow(x[j] - 1e-4 * kP[i][j], 2);
    sum -= kAlpha[i] * std::exp(-exponent);
  }
  return sum;
}

inline double rastrigin(const Vector& x) {
  return 10.0 * static_cast<double>(x.size()) +
         (x.array().square() - 10.0 * (2.0 * std::numbers::pi * x.array()).cos()).sum();
}

/// f evaluated at each row.
inline BatchObjective by_rows(double (*f)(const Vector&)) {
  return [f](const Matrix& rows) {
    Vector values(rows.rows());
    for (Eigen::Index i = 0; i < rows.rows(); ++i) values[i] = f(rows.row(i));
    return values;
  };
}

inline Benchmark branin_benchmark() {
  return {"branin", branin, {Vector{{-5.0, 0.0}}, Vector{{10.0, 15.0}}}, 0.397887357729738};
}
inline Benchmark hartmann6_benchmark() {
  return {"hartmann6", hartmann6, unit_cube(6), -3.3223680114155};
}
inline Benchmark rastrigin_benchmark() {
  // not centred: an algorithm that likes the middle of the box gains nothing
  return {"rastrigin", rastrigin, {Vector::Constant(5, -4.12), Vector::Constant(5, 6.12)}, 0.0};
}

}  // namespace repose::opt::test
