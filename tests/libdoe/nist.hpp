// NIST's certified regressions and analyses of variance [NIST StRD], and how many of their digits
// we reach: for the tests and for the validation page.
#pragma once

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "csv.hpp"
#include "repose/doe/least_squares.hpp"
#include "repose/doe/variance.hpp"

namespace repose::test {

/// Correct digits, -log10 of the relative error (absolute where the certified value is 0), at
/// most 15.
inline double correct_digits(double value, double certified) {
  const double error = certified == 0.0 ? std::abs(value) : std::abs(value / certified - 1.0);
  return error == 0.0 ? 15.0 : std::min(15.0, -std::log10(error));
}

struct NistProblem {
  std::string name;
  int first_power;      ///< 1 leaves the intercept out
  int last_power;       ///< of the polynomial; 0: the columns themselves
  double coefficients;  ///< digits to be exceeded
  double errors;        ///< the same of standard errors; 0: they are exactly zero
};

/// Digits are those published for Householder QR in doubles by several packages, less half a digit
/// for the order of sums.
inline std::vector<NistProblem> nist_problems() {
  return {
      {"Norris", 0, 1, 11.7, 13.0},  {"Pontius", 0, 2, 11.5, 12.3}, {"NoInt1", 1, 1, 14.5, 14.3},
      {"NoInt2", 1, 1, 14.5, 14.3},  {"Filip", 0, 10, 7.0, 7.2},    {"Longley", 0, 0, 10.1, 11.7},
      {"Wampler1", 0, 5, 9.0, 0.0},  {"Wampler2", 0, 5, 12.0, 0.0}, {"Wampler3", 0, 5, 9.0, 12.8},
      {"Wampler4", 0, 5, 7.5, 12.8}, {"Wampler5", 0, 5, 5.5, 12.8}};
}

inline Matrix model_of(const NistProblem& problem, const Csv& data) {
  const auto columns = data.header.size() - 1;
  const Matrix inputs = data.numbers(1, columns);
  const int last = problem.last_power > 0 ? problem.last_power : static_cast<int>(columns);
  Matrix x(inputs.rows(), last - problem.first_power + 1);
  for (int j = problem.first_power; j <= last; ++j)
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      double value = 1.0;
      if (problem.last_power == 0)
        value = j == 0 ? 1.0 : inputs(i, j - 1);
      else
        for (int power = 0; power < j; ++power) value *= inputs(i, 0);
      x(i, j - problem.first_power) = value;
    }
  return x;
}

/// The fewest digits of any coefficient, of any standard error, and of sigma.
struct NistDigits {
  double coefficients = 15.0, errors = 15.0, sigma = 15.0;
  double r_squared = 0.0, certified_r_squared = 0.0;
};

/// Throws InputError unless every coefficient is certified.
inline NistDigits digits_of(const NistProblem& problem) {
  const Csv data = read_csv("nist/" + problem.name + ".csv");
  const Vector y = data.numbers(0, 1);
  const doe::LeastSquaresFit fit = doe::fit_least_squares(model_of(problem, data), y);
  NistDigits digits;
  digits.r_squared = fit.r_squared;
  Eigen::Index compared = 0;
  for (const std::vector<std::string>& row : read_csv("nist/certified_linear.csv").rows) {
    if (row[0] != problem.name) continue;
    const double certified = std::stod(row[2]);
    if (row[1][0] == 'B') {
      const int j = std::stoi(row[1].substr(1)) - problem.first_power;
      digits.coefficients =
          std::min(digits.coefficients, correct_digits(fit.coefficients(j), certified));
      if (problem.errors > 0.0)
        digits.errors =
            std::min(digits.errors, correct_digits(fit.standard_errors(j), std::stod(row[3])));
      ++compared;
    } else if (row[1] == "residual_sd") {
      // An exact fit leaves rounding: digits relative to y.
      digits.sigma = problem.errors > 0.0
                         ? correct_digits(fit.sigma, certified)
                         : correct_digits(fit.sigma / y.cwiseAbs().maxCoeff(), 0.0);
    } else if (row[1] == "r_squared") {
      digits.certified_r_squared = certified;
    }
  }
  if (compared != fit.coefficients.size())
    throw InputError(problem.name + ": not every coefficient is certified");
  return digits;
}

/// One-way analyses of variance; treatments are runs, observations are repetitions.
struct NistAnova {
  std::string name;
  double digits;  ///< of F, to be exceeded; half a digit less of the other quantities
};

/// With 13 constant digits the input itself is rounded to four digits of what varies.
inline std::vector<NistAnova> nist_anovas() {
  return {{"SiRstv", 12.5}, {"AtmWtAg", 9.5}, {"SmLs01", 14.0}, {"SmLs02", 14.0},
          {"SmLs03", 14.0}, {"SmLs04", 9.0},  {"SmLs05", 9.0},  {"SmLs06", 9.0},
          {"SmLs07", 3.0},  {"SmLs08", 3.0},  {"SmLs09", 3.0}};
}

inline Matrix read_nist(const std::string& name, int treatments, int repetitions) {
  std::istringstream text(
      read_file(std::filesystem::path(REPOSE_TEST_DATA) / "doe" / "nist" / (name + ".dat")));
  std::string line;  // the data follow the second line that begins with "Data:"
  for (int found = 0; found < 2 && std::getline(text, line);)
    found += line.rfind("Data:", 0) == 0 ? 1 : 0;
  Matrix values(treatments, repetitions);
  std::vector<int> filled(static_cast<std::size_t>(treatments), 0);
  int treatment = 0;
  double value = 0.0;
  while (text >> treatment >> value)
    values(treatment - 1, filled[static_cast<std::size_t>(treatment - 1)]++) = value;
  return values;
}

/// y_ij = C + o_i + e_j as decimals, correctly rounded: o = 0, -.1, .1, ...; e = .4, .3, .5, .3,
/// ...
inline Matrix simon_lesage(double constant, int repetitions) {
  Matrix values(9, repetitions);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < repetitions; ++j) {
      const int o = i == 0 ? 0 : (i % 2 == 1 ? -1 : 1);
      const int e = j == 0 ? 4 : (j % 2 == 1 ? 3 : 5);
      values(i, j) = (10.0 * constant + o + e) / 10.0;
    }
  return values;
}

inline Matrix values_of(const NistAnova& problem) {
  if (problem.name == "SiRstv") return read_nist("SiRstv", 5, 5);
  if (problem.name == "AtmWtAg") return read_nist("AtmWtAg", 2, 24);
  const int number = problem.name.back() - '1';
  const double constants[] = {1.0, 1e6, 1e12};
  const int repetitions[] = {21, 201, 2001};
  return simon_lesage(constants[number / 3], repetitions[number % 3]);
}

struct NistAnovaDigits {
  double between_ss = 0.0, within_ss = 0.0, f = 0.0, share = 0.0;
};

inline NistAnovaDigits digits_of(const NistAnova& problem) {
  const auto certified = [&](const std::string& quantity) {
    for (const auto& row : read_csv("nist/certified_anova.csv").rows)
      if (row[0] == problem.name && row[2] == quantity) return std::stod(row[3]);
    throw InputError(problem.name + " has no " + quantity);
  };
  const doe::VarianceDecomposition v = doe::decompose_variance(values_of(problem));
  return {correct_digits(v.between_ss, certified("ss_between")),
          correct_digits(v.within_ss, certified("ss_within")), correct_digits(v.f, certified("F")),
          correct_digits(v.parameter_share, certified("r_squared"))};
}

}  // namespace repose::test
