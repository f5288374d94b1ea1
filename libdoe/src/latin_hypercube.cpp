// Latin hypercubes and the swaps that improve them.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "point_filter.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/space_filling.hpp"

namespace repose::doe {
namespace {

using Criterion = LatinHypercubeOptions::Criterion;

constexpr int kMostMaximinPoints = 4000;  // 128 MB of distances
constexpr int kMostThinnedPoints = 1000;  // chosen from twice as many in seconds
constexpr Eigen::Index kMostCoordinates = 50'000'000;

/// A value strictly inside cell `cell` of `cells`. The offset is a multiple of 2^-21, so that cell
/// + offset is exact and neither the division nor a multiplication by `cells` can leave the cell.
double inside_cell(int cell, int cells, RandomStream& random) {
  constexpr std::uint64_t kSteps = 1U << 20;
  const double offset =
      (static_cast<double>(random.below(kSteps)) + 0.5) / static_cast<double>(kSteps);
  return (cell + offset) / cells;
}

Matrix plain_hypercube(int points, int dimensions, RandomStream& random) {
  Matrix x(points, dimensions);
  std::vector<int> cells(static_cast<std::size_t>(points));
  for (int dimension = 0; dimension < dimensions; ++dimension) {
    std::iota(cells.begin(), cells.end(), 0);
    random.shuffle(cells);
    for (int point = 0; point < points; ++point)
      x(point, dimension) = inside_cell(cells[static_cast<std::size_t>(point)], points, random);
  }
  return x;
}

struct Swap {
  int one, other, column;
};

Swap random_swap(const Matrix& x, RandomStream& random) {
  const auto points = static_cast<std::uint64_t>(x.rows());
  const int column = static_cast<int>(random.below(static_cast<std::uint64_t>(x.cols())));
  const int one = static_cast<int>(random.below(points));
  const int other = static_cast<int>(random.below(points - 1));
  return {one, other < one ? other : other + 1, column};
}

/// Squared distances of all points, and sum d^-20 over pairs, kept up to date under swaps.
class DistanceCriterion {
 public:
  explicit DistanceCriterion(Matrix x) : x_(std::move(x)), squared_(x_.rows(), x_.rows()) {
    for (Eigen::Index i = 0; i < x_.rows(); ++i)
      for (Eigen::Index j = 0; j < x_.rows(); ++j)
        squared_(i, j) = (x_.row(i) - x_.row(j)).squaredNorm();
  }

  /// Makes the swap and keeps it if it lowers phi_20.
  bool try_swap(const Swap& swap) {
    const double before = sum_of(swap);
    const Vector old_one = squared_.col(swap.one), old_other = squared_.col(swap.other);
    exchange(swap);
    update(swap.one);
    update(swap.other);
    if (sum_of(swap) < before) return true;
    exchange(swap);
    restore(swap.one, old_one);
    restore(swap.other, old_other);
    return false;
  }

  double smallest() const {
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index j = 1; j < squared_.cols(); ++j)
      least = std::min(least, squared_.col(j).head(j).minCoeff());
    return least;
  }
  const Matrix& points() const { return x_; }

 private:
  static double inverse_power(double squared) {  // d^-20
    const double s2 = squared * squared, s4 = s2 * s2;
    return 1.0 / (s4 * s4 * s2);
  }
  /// The part of the sum in which one of the two points occurs.
  double sum_of(const Swap& swap) const {
    double sum = 0.0;
    for (Eigen::Index k = 0; k < x_.rows(); ++k) {
      if (k == swap.one || k == swap.other) continue;
      sum += inverse_power(squared_(k, swap.one)) + inverse_power(squared_(k, swap.other));
    }
    return sum;
  }
  void exchange(const Swap& swap) {
    std::swap(x_(swap.one, swap.column), x_(swap.other, swap.column));
  }
  void update(int point) {
    for (Eigen::Index k = 0; k < x_.rows(); ++k)
      squared_(k, point) = squared_(point, k) = (x_.row(k) - x_.row(point)).squaredNorm();
  }
  void restore(int point, const Vector& column) {
    squared_.col(point) = column;
    squared_.row(point) = column.transpose();
  }

  Matrix x_;
  Matrix squared_;
};

Matrix maximin_hypercube(Matrix start, int iterations, RandomStream& random) {
  DistanceCriterion criterion(std::move(start));
  Matrix best = criterion.points();
  double best_distance = criterion.smallest();
  for (int i = 0; i < iterations; ++i) {
    if (!criterion.try_swap(random_swap(criterion.points(), random))) continue;
    const double distance = criterion.smallest();
    if (distance > best_distance) {
      best_distance = distance;
      best = criterion.points();
    }
  }
  return best;
}

/// Hill climbing on sum r^2: a swap changes one column's products with the others only.
Matrix uncorrelated_hypercube(Matrix x, int iterations, RandomStream& random) {
  Matrix centred = x.rowwise() - x.colwise().mean();
  Matrix products = centred.transpose() * centred;
  const Vector squares = products.diagonal();
  for (int i = 0; i < iterations; ++i) {
    const Swap swap = random_swap(x, random);
    const double step = centred(swap.other, swap.column) - centred(swap.one, swap.column);
    Vector changed = products.col(swap.column) +
                     step * (centred.row(swap.one) - centred.row(swap.other)).transpose();
    changed(swap.column) = squares(swap.column);
    const auto cost = [&](const Vector& column) {
      return (column.array().square() / squares.array()).sum();
    };
    if (cost(changed) >= cost(products.col(swap.column))) continue;
    products.col(swap.column) = changed;
    products.row(swap.column) = changed.transpose();
    std::swap(x(swap.one, swap.column), x(swap.other, swap.column));
    std::swap(centred(swap.one, swap.column), centred(swap.other, swap.column));
  }
  return x;
}

Matrix hypercube(int points, int dimensions, const LatinHypercubeOptions& options,
                 Criterion criterion) {
  RandomStream random(options.seed);
  Matrix x = plain_hypercube(points, dimensions, random);
  if (points == 1) return x;
  switch (criterion) {
    case Criterion::plain:
      return x;
    case Criterion::maximin:
      return maximin_hypercube(std::move(x), options.iterations, random);
    case Criterion::correlation:
      return uncorrelated_hypercube(std::move(x), options.iterations, random);
  }
  return x;
}

/// `points` rows of x; while there are more, the closest two lose the one with the nearer third.
Matrix thinned(Matrix x, Eigen::Index points) {
  Matrix squared(x.rows(), x.rows());
  for (Eigen::Index j = 0; j < x.rows(); ++j) {
    squared.col(j) = (x.rowwise() - x.row(j)).rowwise().squaredNorm();
    squared(j, j) = std::numeric_limits<double>::infinity();
  }
  Eigen::Index n = x.rows();
  for (; n > points; --n) {
    auto left = squared.topLeftCorner(n, n);
    Eigen::Index one = 0, other = 0;
    left.minCoeff(&one, &other);
    left(one, other) = left(other, one) = std::numeric_limits<double>::infinity();
    const auto leaving = left.col(one).minCoeff() <= left.col(other).minCoeff() ? one : other;
    x.row(leaving) = x.row(n - 1);
    left.row(leaving) = left.row(n - 1).eval();
    left.col(leaving) = left.col(n - 1).eval();
    left(leaving, leaving) = std::numeric_limits<double>::infinity();
  }
  return x.topRows(n);
}

/// The allowed points of plain hypercubes that grow until there are enough; twice as many to choose
/// from where distance counts.
Matrix allowed_hypercube(int points, int dimensions, const LatinHypercubeOptions& options) {
  const bool thin = options.criterion == Criterion::maximin && points <= kMostThinnedPoints;
  const Eigen::Index wanted = thin ? 2 * points : points;
  Eigen::Index total = wanted, tried = 0, found = 0;
  while (true) {
    if (total * dimensions > kMostCoordinates)
      throw InputError(
          fmt::format("Latin hypercube: {} points that obey the constraints need one of {} points; "
                      "take fewer, or a Sobol' sequence",
                      points, total));
    RandomStream random(options.seed);
    const Matrix x =
        allowed_rows(plain_hypercube(static_cast<int>(total), dimensions, random), options.allowed);
    if (x.rows() >= wanted) return thin ? thinned(x, points) : x.topRows(points);
    tried += total;
    found += x.rows();
    require_some_allowed(found, tried);
    const double share = std::max(0.5, static_cast<double>(x.rows())) / static_cast<double>(total);
    total =
        std::max(total + 1, static_cast<Eigen::Index>(1.05 * static_cast<double>(wanted) / share));
  }
}

}  // namespace

Matrix latin_hypercube(int points, int dimensions, const LatinHypercubeOptions& options) {
  if (points < 1 || dimensions < 1)
    throw InputError(
        fmt::format("Latin hypercube: {} points in {} dimensions; both must be at least 1", points,
                    dimensions));
  if (options.iterations < 0)
    throw InputError(
        fmt::format("Latin hypercube: {} iterations; 0 or more are possible", options.iterations));
  if (options.criterion == Criterion::maximin && points > kMostMaximinPoints)
    throw InputError(
        fmt::format("Latin hypercube: {} points by maximin; {} are possible, any number by the "
                    "plain and the correlation criterion",
                    points, kMostMaximinPoints));
  const Matrix x = hypercube(points, dimensions, options, options.criterion);
  if (!options.allowed || allowed_rows(x, options.allowed).rows() == points) return x;
  return allowed_hypercube(points, dimensions, options);
}

}  // namespace repose::doe
