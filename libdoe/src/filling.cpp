// Filters of points, and new points in the gaps between given ones.
#include <fmt/format.h>

#include <limits>
#include <vector>

#include "point_filter.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::doe {
namespace {

/// The cells of one column that hold no point yet.
class EmptyCells {
 public:
  EmptyCells(const Matrix& points, Eigen::Index column, int cells) : cells_(cells) {
    std::vector<bool> taken(static_cast<std::size_t>(cells), false);
    for (const double u : points.col(column)) taken[cell_of(u)] = true;
    for (int cell = 0; cell < cells; ++cell)
      if (!taken[static_cast<std::size_t>(cell)]) empty_.push_back(cell);
  }
  double random_value(RandomStream& random) const {
    if (empty_.empty()) return random.uniform();
    return (empty_[random.below(empty_.size())] + random.uniform()) / cells_;
  }
  int taken() const { return cells_ - static_cast<int>(empty_.size()); }
  void take(double value) { std::erase(empty_, static_cast<int>(cell_of(value))); }

 private:
  std::size_t cell_of(double u) const {
    return static_cast<std::size_t>(std::min<double>(cells_ - 1, u * cells_));
  }
  int cells_;
  std::vector<int> empty_;
};

bool is_nearly_latin(const Matrix& points) {
  const int cells = static_cast<int>(points.rows());
  for (Eigen::Index j = 0; j < points.cols(); ++j)
    if (EmptyCells(points, j, cells).taken() < 0.75 * cells) return false;
  return true;
}

double nearest_distance(const Matrix& points, Eigen::Index rows, const Vector& point) {
  if (rows == 0) return 0.0;
  return (points.topRows(rows).rowwise() - point.transpose()).rowwise().squaredNorm().minCoeff();
}

void check_arguments(const Matrix& existing, int points, const FillingOptions& options) {
  if (existing.cols() < 1)
    throw InputError("points to fill the gaps between: they have no columns");
  if (points < 1 || options.candidates < 1)
    throw InputError(
        fmt::format("points that fill gaps: {} points of {} candidates each; both must be at least "
                    "1",
                    points, options.candidates));
  for (Eigen::Index i = 0; i < existing.rows(); ++i)
    for (Eigen::Index j = 0; j < existing.cols(); ++j)
      if (!(existing(i, j) >= 0.0 && existing(i, j) <= 1.0))
        throw InputError(fmt::format(
            "points to fill the gaps between: row {}, column {} is {}; it must be in [0, 1]", i + 1,
            j + 1, existing(i, j)));
}

}  // namespace

void require_some_allowed(Eigen::Index found, Eigen::Index tried) {
  constexpr Eigen::Index kOneIn = 10000;
  if (tried >= kOneIn * (found + 1))
    throw InputError(
        fmt::format("{} of {} points obey the constraints; that is too few to go on: loosen the "
                    "constraints or narrow the ranges to the region that is allowed",
                    found, tried));
}

PointFilter constraint_filter(const ParameterSpace& space) {
  if (space.constraints().empty()) return {};
  return [&space](const Vector& unit) { return space.obeys_constraints(space.from_unit(unit)); };
}

Matrix allowed_rows(const Matrix& x, const PointFilter& allowed) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (allowed(x.row(i).transpose())) rows.push_back(i);
  return x(rows, Eigen::all);
}

Matrix filling_points(const Matrix& existing, int points, const FillingOptions& options) {
  check_arguments(existing, points, options);
  const Eigen::Index d = existing.cols(), before = existing.rows();
  const int cells = static_cast<int>(before) + points;
  Matrix all(cells, d);
  all.topRows(before) = existing;
  std::vector<EmptyCells> columns;
  for (Eigen::Index j = 0; j < d; ++j) columns.emplace_back(existing, j, cells);

  RandomStream random(options.seed);
  const int in_cells = is_nearly_latin(existing) ? options.candidates : 0;
  for (Eigen::Index row = before; row < cells; ++row) {
    double best = -1.0;
    const auto offer = [&](const Vector& point) {
      if (options.allowed && !options.allowed(point)) return;
      const double distance = nearest_distance(all, row, point);
      if (distance <= best) return;
      best = distance;
      all.row(row) = point.transpose();
    };
    for (int i = 0; i < in_cells; ++i)
      offer(Vector::NullaryExpr(d, [&](Eigen::Index j) {
        return columns[static_cast<std::size_t>(j)].random_value(random);
      }));
    for (Eigen::Index tried = 1; best < 0.0 || (in_cells == 0 && tried <= options.candidates);
         ++tried) {
      offer(Vector::NullaryExpr(d, [&](Eigen::Index) { return random.uniform(); }));
      if (best < 0.0) require_some_allowed(0, tried);
    }
    for (Eigen::Index j = 0; j < d; ++j) columns[static_cast<std::size_t>(j)].take(all(row, j));
  }
  return all.bottomRows(points);
}

}  // namespace repose::doe
