// The expected numbers of the design analyses, written by an independent program.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "repose/base/file.hpp"
#include "repose/doe/least_squares.hpp"

namespace repose::test {

inline nlohmann::json read_expected(const std::string& name) {
  return nlohmann::json::parse(read_file(std::filesystem::path(REPOSE_TEST_DATA) / "doe" / name));
}

/// "X5^2" for the "X5*X5" of the expected numbers.
inline std::string our_name(const std::string& term) {
  const auto star = term.find('*');
  if (star == std::string::npos || term.substr(0, star) != term.substr(star + 1)) return term;
  return term.substr(0, star) + "^2";
}

inline void expect_relative(double value, double expected, double relative = 1e-9) {
  EXPECT_NEAR(value, expected, relative * std::abs(expected));
}

/// Estimate, standard error, t and p of every term by name.
inline void expect_estimates(const doe::LeastSquaresFit& fit, const nlohmann::json& expected) {
  ASSERT_EQ(fit.names.size(), expected.size());
  for (std::size_t j = 0; j < fit.names.size(); ++j) {
    bool found = false;
    for (const auto& [name, numbers] : expected.items()) {
      if (our_name(name) != fit.names[j]) continue;
      found = true;
      SCOPED_TRACE(name);
      const auto i = static_cast<Eigen::Index>(j);
      expect_relative(fit.coefficients(i), numbers[0]);
      expect_relative(fit.standard_errors(i), numbers[1]);
      expect_relative(fit.t(i), numbers[2]);
      expect_relative(fit.p(i), numbers[3]);
    }
    EXPECT_TRUE(found) << fit.names[j];
  }
}

}  // namespace repose::test
