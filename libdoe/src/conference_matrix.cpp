// Conference matrices by Paley, doubling, Goethals-Seidel and Mathon.
#include <fmt/format.h>

#include <array>
#include <string_view>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/doe/designs.hpp"

namespace repose::doe {
namespace {

using Eigen::MatrixXi;

constexpr int kLargestOrder = 128;

struct PrimePower {
  int prime = 0;
  int exponent = 0;
};

/// prime = 0 if q is no power of an odd prime.
PrimePower odd_prime_power(int q) {
  for (int p = 3; p <= q; p += 2) {
    if (q % p != 0) continue;
    PrimePower result{p, 0};
    for (int rest = q; rest > 1; rest /= p, ++result.exponent)
      if (rest % p != 0) return {};
    return result;
  }
  return {};
}

bool is_sum_of_two_squares(int number) {
  for (int a = 0; a * a <= number; ++a)
    for (int b = a; a * a + b * b <= number; ++b)
      if (a * a + b * b == number) return true;
  return false;
}

/// GF(p^e): elements are 0 ... q-1, whose digits to base p are the coefficients of a polynomial.
class GaloisField {
 public:
  explicit GaloisField(PrimePower order) : p_(order.prime), e_(order.exponent), q_(1) {
    for (int i = 0; i < e_; ++i) q_ *= p_;
    // x^e = modulus(x): the first choice that leaves no divisors of zero, that is, an irreducible
    // one.
    for (modulus_ = 0; modulus_ < q_ && has_zero_divisors();) ++modulus_;
    REPOSE_ASSERT(modulus_ < q_, fmt::format("q = {}", q_));
    character_.assign(static_cast<std::size_t>(q_), -1);
    character_[0] = 0;
    for (int a = 1; a < q_; ++a) character_[static_cast<std::size_t>(multiply(a, a))] = 1;
  }

  int size() const { return q_; }
  int prime() const { return p_; }
  /// 1 for non-zero squares, -1 for non-squares, 0 for 0.
  int character(int a) const { return character_[static_cast<std::size_t>(a)]; }

  int subtract(int a, int b) const {
    int difference = 0;
    for (int power = 1; power < q_; power *= p_, a /= p_, b /= p_)
      difference += (a % p_ - b % p_ + p_) % p_ * power;
    return difference;
  }

 private:
  int add(int a, int b) const { return subtract(a, subtract(0, b)); }
  int scale(int a, int factor) const {
    int result = 0;
    for (int power = 1; power < q_; power *= p_, a /= p_) result += a % p_ * factor % p_ * power;
    return result;
  }
  int times_x(int a) const {
    const int leading = a / (q_ / p_);
    return add(a % (q_ / p_) * p_, scale(modulus_, leading));
  }
  int multiply(int a, int b) const {  // Horner over the digits of b
    int result = 0;
    for (int power = q_ / p_; power > 0; power /= p_)
      result = add(e_ == 1 ? 0 : times_x(result), scale(a, b / power % p_));
    return result;
  }
  bool has_zero_divisors() const {
    if (e_ == 1) return false;
    for (int a = 1; a < q_; ++a)
      for (int b = a; b < q_; ++b)
        if (multiply(a, b) == 0) return true;
    return false;
  }

  int p_, e_, q_;
  int modulus_ = 0;
  std::vector<int> character_;
};

/// Paley's core Q_ij = chi(a_i - a_j).
MatrixXi paley_core(const GaloisField& field) {
  const int q = field.size();
  MatrixXi core(q, q);
  for (int i = 0; i < q; ++i)
    for (int j = 0; j < q; ++j) core(i, j) = field.character(field.subtract(i, j));
  return core;
}

enum class Border { symmetric, skew };

MatrixXi with_border(const MatrixXi& core, Border border) {
  const Eigen::Index n = core.rows() + 1;
  MatrixXi c = MatrixXi::Zero(n, n);
  c.row(0).tail(n - 1).setOnes();
  c.col(0).tail(n - 1).setConstant(border == Border::symmetric ? 1 : -1);
  c.bottomRightCorner(n - 1, n - 1) = core;
  return c;
}

MatrixXi paley(int order) {
  const int q = order - 1;
  const GaloisField field(odd_prime_power(q));
  return with_border(paley_core(field), q % 4 == 1 ? Border::symmetric : Border::skew);
}

/// [[S, S+I], [S-I, -S]] of a skew conference matrix S is skew again.
MatrixXi doubled(const MatrixXi& s) {
  const Eigen::Index n = s.rows();
  const MatrixXi identity = MatrixXi::Identity(n, n);
  MatrixXi c(2 * n, 2 * n);
  c << s, s + identity, s - identity, -s;
  return c;
}

MatrixXi circulant(std::string_view signs) {
  const int v = static_cast<int>(signs.size());
  MatrixXi m(v, v);
  for (int i = 0; i < v; ++i)
    for (int j = 0; j < v; ++j)
      m(i, j) = signs[static_cast<std::size_t>((j - i + v) % v)] == '+' ? 1 : -1;
  return m;
}

/// The Goethals-Seidel array of four circulants, A of skew type, less the identity.
MatrixXi goethals_seidel(const std::array<std::string_view, 4>& first_rows) {
  const MatrixXi a = circulant(first_rows[0]), b = circulant(first_rows[1]),
                 c = circulant(first_rows[2]), d = circulant(first_rows[3]);
  const Eigen::Index v = a.rows();
  const MatrixXi r = MatrixXi::Identity(v, v).rowwise().reverse();
  MatrixXi h(4 * v, 4 * v);
  h << a, b * r, c * r, d * r,                           //
      -b * r, a, d.transpose() * r, -c.transpose() * r,  //
      -c * r, -d.transpose() * r, a, b.transpose() * r,  //
      -d * r, c.transpose() * r, -b.transpose() * r, a;
  return h - MatrixXi::Identity(4 * v, 4 * v);
}

/// Order 46: a core of 5 x 5 blocks of 9 x 9. Diagonal blocks are Paley's core of GF(9); block (i,
/// j) is eps_ij where the line of x in parallel class (j - i) of the affine plane GF(9) has the
/// number of the line of y in class (i - j), -eps_ij elsewhere, eps being Paley's core of GF(5).
MatrixXi mathon_46() {
  const GaloisField nine({3, 2});
  const MatrixXi diagonal = paley_core(nine);
  const MatrixXi eps = paley_core(GaloisField({5, 1}));
  // One direction of each of the four parallel classes, the two of squares first.
  std::vector<int> directions;
  for (const int square : {1, -1})
    for (const int direction : {1, 3, 4, 5})
      if (nine.character(direction) == square) directions.push_back(direction);
  const auto line = [&](int point, int shift) {
    const int direction = directions[static_cast<std::size_t>(shift - 1)];
    return ((point % 3) * (direction / 3) - (point / 3) * (direction % 3) + 9) % 3;
  };
  MatrixXi core(45, 45);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      for (int x = 0; x < 9; ++x)
        for (int y = 0; y < 9; ++y) {
          int& entry = core(9 * i + x, 9 * j + y);
          if (i == j)
            entry = diagonal(x, y);
          else
            entry = line(x, (j - i + 5) % 5) == line(y, (i - j + 5) % 5) ? eps(i, j) : -eps(i, j);
        }
  return with_border(core, Border::symmetric);
}

bool has_special_construction(int order) {
  return order == 36 || order == 46 || order == 52;
}

bool is_built(int order) {
  if (order < 4 || order % 2 != 0 || order > kLargestOrder) return false;
  if (odd_prime_power(order - 1).prime != 0 || has_special_construction(order)) return true;
  return order % 8 == 0 && is_built(order / 2);  // half of it is then a multiple of 4: skew
}

MatrixXi build(int order) {
  if (odd_prime_power(order - 1).prime != 0) return paley(order);
  switch (order) {
    case 36:
      return goethals_seidel({"++++-+---", "+---++---", "+++-++-++", "++-+--+-+"});
    case 46:
      return mathon_46();
    case 52:
      return goethals_seidel({"++--+-+-+-++-", "+-++--++--++-", "+++++----++++", "+-++++--++++-"});
    default:
      return doubled(build(order / 2));
  }
}

}  // namespace

int conference_order(int at_least) {
  for (int order = at_least < 4 ? 4 : at_least + at_least % 2; order <= kLargestOrder; order += 2)
    if (is_built(order)) return order;
  throw InputError(
      fmt::format("conference matrix of order {} or more: the largest one built here has "
                  "order {}; ask for fewer factors",
                  at_least, kLargestOrder));
}

MatrixXi conference_matrix(int order) {
  if (order < 4 || order % 2 != 0 || order > kLargestOrder)
    throw InputError(fmt::format("conference matrix: order {} is not an even number from 4 to {}",
                                 order, kLargestOrder));
  if (order % 4 == 2 && !is_sum_of_two_squares(order - 1))
    throw InputError(
        fmt::format("conference matrix: order {} does not exist, because {} is not a sum of "
                    "two squares; the next order built here is {}",
                    order, order - 1, conference_order(order)));
  if (!is_built(order))
    throw InputError(
        fmt::format("conference matrix: order {} is not built here; the next one that is, is {}",
                    order, conference_order(order)));
  const MatrixXi c = build(order);
  REPOSE_ASSERT(c * c.transpose() == (order - 1) * MatrixXi::Identity(order, order),
                fmt::format("order = {}", order));
  return c;
}

}  // namespace repose::doe
