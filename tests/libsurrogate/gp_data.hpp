// Data of the Gaussian process tests: files, functions, designs.
#pragma once

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "repose/base/random.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate::test {

/// Numbers of a CSV with one header line, the leading index column dropped.
inline Matrix read_indexed_csv(const std::string& name) {
  const std::string path = std::string(REPOSE_TEST_DATA) + "/gp/" + name;
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  std::string line;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::stringstream cells(line);
    std::string cell;
    std::vector<double> row;
    while (std::getline(cells, cell, ',')) row.push_back(std::stod(cell));
    rows.push_back(row);
  }
  Matrix m(static_cast<Eigen::Index>(rows.size()),
           static_cast<Eigen::Index>(rows.at(0).size()) - 1);
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index k = 0; k < m.cols(); ++k)
      m(i, k) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(k) + 1];
  return m;
}

inline opt::Bounds range_of(const Matrix& x) {
  return {x.colwise().minCoeff(), x.colwise().maxCoeff()};
}

inline Matrix uniform_points(Eigen::Index n, Eigen::Index d, std::uint64_t seed) {
  RandomStream random(seed);
  Matrix x(n, d);
  for (double& value : x.reshaped()) value = random.uniform();
  return x;
}

/// A smooth function of the unit cube with interactions; inputs of falling importance.
inline double smooth_function(const Vector& x) {
  double sum = std::sin(4.0 * x[0]);
  for (Eigen::Index k = 1; k < x.size(); ++k)
    sum += std::cos(3.0 * x[k] + x[k - 1]) / static_cast<double>(k + 1);
  return sum;
}

inline Vector at_rows(const Matrix& x, double (*f)(const Vector&)) {
  Vector y(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) y[i] = f(x.row(i));
  return y;
}

/// 30 rows of which the last 8 repeat earlier points, with noise.
struct Sample {
  Matrix x = uniform_points(30, 3, 5);
  Vector y;
  opt::Bounds cube = opt::unit_cube(3);
  Hyperparameters given{Vector{{0.4, 0.8, 1.1}}, 0.9, 0.02};
  explicit Sample(Eigen::Index repeats = 8) {
    for (Eigen::Index i = 0; i < repeats; ++i) x.row(29 - i) = x.row(i % 4);
    y = at_rows(x, smooth_function);
    RandomStream random(6);
    for (double& value : y) value += 0.1 * random.normal();
  }
};

}  // namespace repose::surrogate::test
