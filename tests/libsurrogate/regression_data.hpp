// Data of the tests of regressors and of cross-validation.
#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "gp_data.hpp"
#include "repose/surrogate/training_set.hpp"

namespace repose::surrogate::test {

/// Columns of numbers of a CSV below tests/data, by name.
inline std::map<std::string, Vector> read_columns(const std::string& file) {
  const std::string path = std::string(REPOSE_TEST_DATA) + "/" + file;
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::stringstream stream(line.substr(0, line.find('\r')));
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(in, line);
  const auto names = cells_of(line);
  std::map<std::string, std::vector<double>> values;
  while (std::getline(in, line)) {
    const auto cells = cells_of(line);
    for (std::size_t k = 0; k < names.size(); ++k)
      values[names[k]].push_back(std::stod(cells.at(k)));
  }
  std::map<std::string, Vector> columns;
  for (const auto& [name, v] : values)
    columns[name] = Eigen::Map<const Vector>(v.data(), static_cast<Eigen::Index>(v.size()));
  return columns;
}

/// These columns side by side.
inline Matrix matrix_of(const std::map<std::string, Vector>& columns,
                        const std::vector<std::string>& names) {
  Matrix m(columns.begin()->second.size(), static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k)
    m.col(static_cast<Eigen::Index>(k)) = columns.at(names[k]);
  return m;
}

/// n rows of the smooth function of d inputs in [0, 1], with normal noise.
inline TrainingSet smooth_data(Eigen::Index n, Eigen::Index d, double noise = 0.05,
                               std::uint64_t seed = 11) {
  TrainingSet data{.x = uniform_points(n, d, seed),
                   .y = {},
                   .inputs = std::vector<Input>(static_cast<std::size_t>(d))};
  data.y = at_rows(data.x, smooth_function);
  RandomStream random(seed, 1);
  for (double& value : data.y) value += noise * random.normal();
  return data;
}

}  // namespace repose::surrogate::test
