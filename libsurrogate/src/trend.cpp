#include "trend.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

/// A column whose part independent of the others is below this fraction of it depends on them.
constexpr double kDependent = 1e-10;
constexpr double kDifferenceStep = 1e-5;

/// One regression function of the basis beyond the constant: a coordinate, perhaps squared.
struct Term {
  Eigen::Index coordinate;
  bool squared;
};

bool has_indicators(const Input& input) {
  return input.is_categorical() && input.coding != Coding::label;
}

const Input& input_of(const Encoding& encoding, Eigen::Index coordinate) {
  return encoding.inputs()[static_cast<std::size_t>(encoding.input_of(coordinate))];
}

/// Coordinates first, then squares. With a constant the first indicator of a category is left out,
/// and so are squares that two levels make equal to the coordinate.
std::vector<Term> terms_of(Basis basis, const Encoding& encoding) {
  std::vector<Term> terms;
  if (basis != Basis::linear && basis != Basis::quadratic) return terms;
  for (Eigen::Index p = 0; p < encoding.coordinates(); ++p) {
    const bool first = p == 0 || encoding.input_of(p) != encoding.input_of(p - 1);
    if (!(first && has_indicators(input_of(encoding, p)))) terms.push_back({p, false});
  }
  if (basis == Basis::linear) return terms;
  for (Eigen::Index p = 0; p < encoding.coordinates(); ++p) {
    const Input& input = input_of(encoding, p);
    if (!has_indicators(input) && input.levels.size() != 2) terms.push_back({p, true});
  }
  return terms;
}

/// An indicator counts 1 whatever the encoding makes of it.
double indicator_unit(const Encoding& encoding, Eigen::Index p) {
  const Input& input = input_of(encoding, p);
  return has_indicators(input) && input.coding == Coding::exchangeable ? std::sqrt(2.0) : 1.0;
}

Vector user_values(const BasisFunctions& functions, const Vector& natural) {
  const Vector values = functions.evaluate(natural);
  if (values.size() != static_cast<Eigen::Index>(functions.names.size()) || !values.allFinite())
    throw InputError(fmt::format(
        "the regression functions of the user gave {} values, some perhaps not finite; they must "
        "give {} finite ones",
        values.size(), functions.names.size()));
  return values;
}

}  // namespace

std::vector<std::string> trend_names(const Trend& trend, const Encoding& encoding) {
  std::vector<std::string> names;
  if (trend.has_constant()) names.emplace_back("1");
  for (const Term& term : terms_of(trend.basis, encoding)) {
    std::string name = fmt::format("input {}", encoding.input_of(term.coordinate) + 1);
    if (has_indicators(input_of(encoding, term.coordinate))) name += ", a level";
    names.push_back(term.squared ? name + " squared" : name);
  }
  for (const std::string& name : trend.functions.names) names.push_back("function " + name);
  return names;
}

Matrix trend_matrix(const Trend& trend, const Encoding& encoding, const Matrix& natural,
                    const Matrix& encoded) {
  const std::vector<Term> terms = terms_of(trend.basis, encoding);
  const Eigen::Index users = static_cast<Eigen::Index>(trend.functions.names.size());
  const Eigen::Index first = trend.has_constant() ? 1 : 0;
  Matrix h(encoded.rows(), first + static_cast<Eigen::Index>(terms.size()) + users);
  if (first > 0) h.col(0).setOnes();
  Eigen::Index column = first;
  for (const Term& term : terms) {
    h.col(column) = indicator_unit(encoding, term.coordinate) * encoded.col(term.coordinate);
    if (term.squared) h.col(column) = h.col(column).cwiseAbs2().eval();
    ++column;
  }
  if (users > 0)
    for (Eigen::Index i = 0; i < natural.rows(); ++i)
      h.row(i).tail(users) = user_values(trend.functions, natural.row(i));
  return h;
}

Matrix trend_jacobian(const Trend& trend, const Encoding& encoding, const Vector& natural,
                      const Vector& encoded) {
  const std::vector<Term> terms = terms_of(trend.basis, encoding);
  const Eigen::Index users = static_cast<Eigen::Index>(trend.functions.names.size());
  Eigen::Index row = trend.has_constant() ? 1 : 0;
  Matrix j = Matrix::Zero(row + static_cast<Eigen::Index>(terms.size()) + users, natural.size());
  for (const Term& term : terms) {
    const Eigen::Index input = encoding.input_of(term.coordinate);
    const double slope = encoding.derivative(input, natural[input]);
    j(row++, input) = term.squared ? 2.0 * encoded[term.coordinate] * slope : slope;
  }
  if (users == 0) return j;
  for (Eigen::Index k = 0; k < natural.size(); ++k) {
    const double slope = encoding.derivative(k, natural[k]);
    if (slope == 0.0) continue;
    const double step = kDifferenceStep / slope;
    Vector above = natural;
    Vector below = natural;
    above[k] += step;
    below[k] -= step;
    j.col(k).tail(users) =
        (user_values(trend.functions, above) - user_values(trend.functions, below)) /
        (above[k] - below[k]);
  }
  return j;
}

void check_independent(const Matrix& h, const std::vector<std::string>& names) {
  Matrix basis(h.rows(), h.cols());  // orthonormal, Gram and Schmidt, twice
  for (Eigen::Index c = 0; c < h.cols(); ++c) {
    Vector v = h.col(c);
    const double length = v.norm();
    for (int pass = 0; pass < 2; ++pass)
      v -= basis.leftCols(c) * (basis.leftCols(c).transpose() * v);
    if (!(v.norm() > kDependent * length))
      throw InputError(fmt::format(
          "the regression function '{}' depends on those before it at the points of the data: "
          "choose a smaller basis, or leave out the input that does not vary",
          names[static_cast<std::size_t>(c)]));
    basis.col(c) = v / v.norm();
  }
}

}  // namespace repose::surrogate
