// Hadamard matrices and Plackett-Burman designs.
#include <fmt/format.h>

#include <optional>

#include "repose/base/error.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/factorial.hpp"

namespace repose::doe {
namespace {

using Eigen::MatrixXi;

constexpr int kLargestOrder = 256;

std::optional<MatrixXi> conference_matrix_if_built(int order) {
  if (order < 4 || order > 128 || conference_order(order) != order) return std::nullopt;
  return conference_matrix(order);
}

MatrixXi in_blocks(const MatrixXi& a, const MatrixXi& b, const MatrixXi& c, const MatrixXi& d) {
  MatrixXi h(2 * a.rows(), 2 * a.cols());
  h << a, b, c, d;
  return h;
}

/// Not normalised; none if no construction here gives the order.
std::optional<MatrixXi> built(int order) {
  if (order == 1) return MatrixXi::Ones(1, 1);
  if (order == 2) return in_blocks(*built(1), *built(1), *built(1), -*built(1));
  if (order % 4 != 0) return std::nullopt;
  // A skew conference matrix plus I; a symmetric one C in [[C + I, C - I], [C - I, -C - I]].
  const MatrixXi one = MatrixXi::Identity(order, order);
  if (const auto c = conference_matrix_if_built(order); c && *c == -c->transpose()) return *c + one;
  const MatrixXi half = MatrixXi::Identity(order / 2, order / 2);
  if (const auto c = conference_matrix_if_built(order / 2); c && *c == c->transpose())
    return in_blocks(*c + half, *c - half, *c - half, -*c - half);
  if (const auto h = built(order / 2)) return in_blocks(*h, *h, *h, -*h);
  return std::nullopt;
}

}  // namespace

MatrixXi hadamard_matrix(int order) {
  const auto h = order >= 1 && order <= kLargestOrder ? built(order) : std::nullopt;
  if (!h)
    throw InputError(fmt::format(
        "Hadamard matrix: order {} is not built here; 1, 2, multiples of 4 up to 100 and most of "
        "them up to {} are",
        order, kLargestOrder));
  REPOSE_ASSERT(*h * h->transpose() == order * MatrixXi::Identity(order, order),
                fmt::format("order {}", order));
  return h->col(0).asDiagonal() * *h;
}

Matrix plackett_burman(int factors, FoldOverRuns fold_over) {
  if (factors < 1 || factors > 99)
    throw InputError(
        fmt::format("Plackett-Burman design: {} factors; from 1 to 99 are possible", factors));
  const int order = 4 * (factors / 4 + 1);
  const Matrix half = hadamard_matrix(order).middleCols(1, factors).cast<double>();
  if (fold_over == FoldOverRuns::none) return half;
  Matrix coded(2 * order, factors);
  coded << half, -half;
  return coded;
}

}  // namespace repose::doe
