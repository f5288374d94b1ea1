// Full and fractional factorial designs.
#include "repose/doe/factorial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>

#include "fractions.hpp"
#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

constexpr char kLetters[] = "ABCDEFGHJKLMNOPQRSTUVWXYZ";  // I is the identity
constexpr int kMostFactors = 25;
constexpr int kMostBaseFactors = 16;
constexpr double kMostRuns = 1e6;

std::vector<FactorProduct> sorted_relation(std::vector<FactorProduct> words) {
  std::sort(words.begin(), words.end(), [](FactorProduct a, FactorProduct b) {
    const int la = std::popcount(a), lb = std::popcount(b);
    const FactorProduct first_difference = (a ^ b) & -(a ^ b);
    return la != lb ? la < lb : (a & first_difference) != 0;
  });
  return words;
}

void check_factors(int factors) {
  if (factors < 1 || factors > kMostFactors)
    throw InputError(fmt::format("two-level factorial: {} factors; from 1 to {} are possible",
                                 factors, kMostFactors));
}

}  // namespace

std::string product_name(FactorProduct product) {
  std::string name;
  for (int j = 0; j < kMostFactors; ++j)
    if ((product >> j & 1U) != 0) name += kLetters[j];
  return name.empty() ? "I" : name;
}

FactorProduct product_named(const std::string& name) {
  const std::string letters = kLetters;
  FactorProduct product = 0;
  for (const char c : name) {
    const auto place = letters.find(static_cast<char>(std::toupper(static_cast<unsigned char>(c))));
    if (place == std::string::npos)
      throw InputError(
          fmt::format("product of factors \"{}\": {} is no factor; they are called A, B, ... Z "
                      "without I",
                      name, c));
    const FactorProduct bit = FactorProduct{1} << place;
    if ((product & bit) != 0)
      throw InputError(fmt::format("product of factors \"{}\": {} occurs twice", name, c));
    product |= bit;
  }
  return product;
}

Matrix full_factorial(const std::vector<int>& levels) {
  double runs = 1.0;
  for (std::size_t j = 0; j < levels.size(); ++j) {
    if (levels[j] < 2)
      throw InputError(
          fmt::format("full factorial: factor {} has {} levels; it needs two or more, or must be "
                      "fixed",
                      j + 1, levels[j]));
    runs *= levels[j];
  }
  if (levels.empty() || runs > kMostRuns)
    throw InputError(
        fmt::format("full factorial: {} runs of {} factors; up to {} are possible: use a fraction "
                    "or a space-filling design",
                    runs, levels.size(), kMostRuns));
  Matrix coded(static_cast<Eigen::Index>(runs), static_cast<Eigen::Index>(levels.size()));
  Eigen::Index period = 1;
  for (std::size_t j = 0; j < levels.size(); ++j) {
    for (Eigen::Index run = 0; run < coded.rows(); ++run)
      coded(run, static_cast<Eigen::Index>(j)) =
          2.0 * static_cast<double>(run / period % levels[j]) / (levels[j] - 1) - 1.0;
    period *= levels[j];
  }
  return coded;
}

std::vector<int> FractionalFactorial::word_length_pattern() const {
  std::vector<int> pattern(static_cast<std::size_t>(coded.cols()) + 1, 0);
  for (const FactorProduct word : defining_relation)
    ++pattern[static_cast<std::size_t>(std::popcount(word))];
  return pattern;
}

FractionalFactorial fraction_of(int base_factors, std::vector<FactorProduct> generators) {
  FractionalFactorial design;
  const Matrix base = full_factorial(std::vector<int>(static_cast<std::size_t>(base_factors), 2));
  design.coded.resize(base.rows(), base_factors + static_cast<int>(generators.size()));
  design.coded.leftCols(base_factors) = base;
  std::vector<FactorProduct> words{0};
  for (std::size_t g = 0; g < generators.size(); ++g) {
    const auto column = base_factors + static_cast<int>(g);
    design.coded.col(column).setOnes();
    for (int j = 0; j < base_factors; ++j)
      if ((generators[g] >> j & 1U) != 0) design.coded.col(column).array() *= base.col(j).array();
    const FactorProduct word = generators[g] | FactorProduct{1} << column;
    for (std::size_t i = 0, n = words.size(); i < n; ++i) words.push_back(words[i] ^ word);
  }
  words.erase(words.begin());
  design.base_factors = base_factors;
  design.generators = std::move(generators);
  design.defining_relation = sorted_relation(std::move(words));
  if (!design.defining_relation.empty())
    design.resolution = std::popcount(design.defining_relation.front());
  return design;
}

FractionalFactorial fractional_factorial(int factors, const std::vector<std::string>& generators) {
  check_factors(factors);
  const int base_factors = factors - static_cast<int>(generators.size());
  if (base_factors < 1 || base_factors > kMostBaseFactors)
    throw InputError(fmt::format(
        "two-level factorial: {} generators for {} factors leave {} base factors; from 1 to {} are "
        "possible",
        generators.size(), factors, base_factors, kMostBaseFactors));
  std::vector<FactorProduct> products(generators.size(), 0);
  for (const std::string& text : generators) {
    const auto equals = text.find('=');
    const FactorProduct left =
        equals == std::string::npos ? 0 : product_named(text.substr(0, equals));
    const int factor = std::countr_zero(left);
    if (std::popcount(left) != 1 || factor < base_factors || factor >= factors)
      throw InputError(
          fmt::format("generator \"{}\": give it as FACTOR=PRODUCT, e.g. {}=AB, for each factor "
                      "from {} to {}",
                      text, product_name(FactorProduct{1} << base_factors),
                      product_name(FactorProduct{1} << base_factors),
                      product_name(FactorProduct{1} << (factors - 1))));
    const FactorProduct right = product_named(text.substr(equals + 1));
    if (right >> base_factors != 0 || std::popcount(right) < 2)
      throw InputError(
          fmt::format("generator \"{}\": the product must be of two or more of the first {} "
                      "factors, {}",
                      text, base_factors, product_name((FactorProduct{1} << base_factors) - 1)));
    auto& product = products[static_cast<std::size_t>(factor - base_factors)];
    if (product != 0 || std::count(products.begin(), products.end(), right) > 0)
      throw InputError(
          fmt::format("generator \"{}\": its factor or its product is given twice; two "
                      "factors would have the same column",
                      text));
    product = right;
  }
  return fraction_of(base_factors, std::move(products));
}

}  // namespace repose::doe
