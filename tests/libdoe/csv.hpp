// Reads the small CSV files of tests/data/doe.
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/parameter_space.hpp"

namespace repose::test {

struct Csv {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;

  std::size_t column(const std::string& name) const {
    for (std::size_t j = 0; j < header.size(); ++j)
      if (header[j] == name) return j;
    throw InputError("no column " + name);
  }
  /// The columns first ... first + count - 1 as numbers.
  Matrix numbers(std::size_t first, std::size_t count) const {
    Matrix m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < count; ++j)
        m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            std::stod(rows[i].at(first + j));
    return m;
  }
};

inline std::vector<std::string> split_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',')
      fields.emplace_back();
    else if (c != '\r')
      fields.back() += c;
  }
  return fields;
}

inline Csv read_csv(const std::string& name) {
  std::istringstream text(read_file(std::filesystem::path(REPOSE_TEST_DATA) / "doe" / name));
  Csv csv;
  std::string line;
  while (std::getline(text, line)) {
    if (csv.header.empty())
      csv.header = split_fields(line);
    else if (!line.empty())
      csv.rows.push_back(split_fields(line));
  }
  return csv;
}

/// Coded levels and response of one of the dsd_fit_case files, whose last column is y.
struct Case {
  std::vector<std::string> factors;
  Matrix coded;
  Vector y;
};

inline Case read_case(const std::string& name) {
  const Csv csv = read_csv("dsd_fit_case_" + name + ".csv");
  const std::size_t factors = csv.header.size() - 1;
  return {
      {csv.header.begin(), csv.header.end() - 1}, csv.numbers(0, factors), csv.numbers(factors, 1)};
}

}  // namespace repose::test
