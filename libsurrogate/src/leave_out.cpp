// Predictions of what was left out, in closed form.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "repose/base/error.hpp"
#include "response.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using State = ModelAccess::State;
using Rows = std::vector<Eigen::Index>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Below this fraction of (C^-1)_ii, points alone determine a regression coefficient.
constexpr double kUndetermined = 1e-12;

/// Something left out as a whole: the mean of a point's observations where all of them are, else
/// one observation.
struct Item {
  Eigen::Index point;
  Eigen::Index row;  ///< -1: the mean
};

/// Precision Q of the observations with the trend taken out, and Qy, without ever forming them.
/// With ratio = v/w (its weight in the mean of its point), an observation has, for D = noise w,
/// Q_jk = [same point] (delta_jk - ratio_k)/D_j + ratio_j ratio_k Q_point, (Qy)_j = (y_j -
/// mean)/D_j
/// + ratio_j (Qy)_point: from (A R A^T + D)^-1 by Woodbury.
class Precision {
 public:
  explicit Precision(const State& s) : s_(s) {
    const Matrix inverse = lower_inverse(s.factor.l);
    full_ = inverse.colwise().squaredNorm();
    q_ = inverse_from(inverse).selfadjointView<Eigen::Lower>();
    const Matrix b = inverse.transpose() * s.factor.q1;
    q_.noalias() -= b * b.transpose();
  }

  double entry(const Item& a, const Item& b) const {
    const double between = share(a) * share(b) * q_(a.point, b.point);
    if (a.row < 0 || b.row < 0 || a.point != b.point) return between;
    return between + ((a.row == b.row ? 1.0 : 0.0) - share(b)) / noise(a);
  }
  double times_y(const Item& a) const {
    const double between = share(a) * s_.factor.alpha[a.point];
    if (a.row < 0) return between;
    const auto row = static_cast<std::size_t>(a.row);
    return between + (s_.data.value_of_row[row] - s_.data.y[a.point]) / noise(a);
  }
  /// Of the same without a trend: what `entry` is small against where it is nothing but rounding.
  double scale(const Item& a) const { return share(a) * share(a) * full_[a.point]; }

 private:
  double noise(const Item& a) const {
    return s_.covariance.noise_ratio * s_.data.noise_of_row[static_cast<std::size_t>(a.row)];
  }
  double share(const Item& a) const {
    return a.row < 0
               ? 1.0
               : s_.data.noise[a.point] / s_.data.noise_of_row[static_cast<std::size_t>(a.row)];
  }

  const State& s_;
  Vector full_;
  Matrix q_;
};

/// What the rest says of the items of a group: residual = item - mean, and the residuals'
/// covariance, in units of the process variance.
struct Omitted {
  Vector residual;
  Matrix covariance;
  double log_det = 0.0;
  bool defined = false;
};

/// e_G = Q_GG^-1 (Qy)_G with covariance Q_GG^-1 [Ginsbourger2024].
Omitted omit(const Precision& precision, const std::vector<Item>& items) {
  const auto m = static_cast<Eigen::Index>(items.size());
  Matrix q(m, m);
  Vector qy(m);
  Vector root(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const Item& a = items[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j)
      q(i, j) = precision.entry(a, items[static_cast<std::size_t>(j)]);
    qy[i] = precision.times_y(a);
    if (!(q(i, i) > kUndetermined * precision.scale(a))) return {};
    root[i] = std::sqrt(q(i, i));
  }
  for (Eigen::Index i = 0; i < m; ++i)  // unit diagonal: pivots tell what is determined
    for (Eigen::Index j = 0; j <= i; ++j) q(i, j) /= root[i] * root[j];
  const Eigen::LLT<Matrix> llt(q);
  if (llt.info() != Eigen::Success) return {};
  const Vector pivots = llt.matrixLLT().diagonal();
  if (!(pivots.minCoeff() * pivots.minCoeff() > kUndetermined)) return {};
  Omitted result{.defined = true};
  const Vector inverse_root = root.cwiseInverse();
  result.residual = inverse_root.asDiagonal() * llt.solve(inverse_root.cwiseProduct(qy));
  result.covariance =
      inverse_root.asDiagonal() * llt.solve(Matrix::Identity(m, m)) * inverse_root.asDiagonal();
  result.log_det = -2.0 * (pivots.array().log().sum() + root.array().log().sum());
  return result;
}

/// Groups of rows, whole points found out.
struct Group {
  Rows rows;
  std::vector<Item> items;
  std::vector<std::size_t> item_of_row;
};

Group make_group(const State& s, Rows rows) {
  const Dataset& data = s.data;
  std::map<Eigen::Index, Eigen::Index> seen;
  for (const Eigen::Index row : rows) ++seen[data.point_of_row[static_cast<std::size_t>(row)]];
  std::vector<Eigen::Index> count(static_cast<std::size_t>(data.points()), 0);
  for (const Eigen::Index point : data.point_of_row) ++count[static_cast<std::size_t>(point)];
  Group group{.rows = std::move(rows)};
  std::map<Eigen::Index, std::size_t> item_of_point;
  for (const Eigen::Index row : group.rows) {
    const Eigen::Index point = data.point_of_row[static_cast<std::size_t>(row)];
    const bool whole = seen[point] == count[static_cast<std::size_t>(point)];
    if (whole && item_of_point.contains(point)) {
      group.item_of_row.push_back(item_of_point[point]);
      continue;
    }
    group.item_of_row.push_back(group.items.size());
    if (whole) item_of_point[point] = group.items.size();
    group.items.push_back({point, whole ? -1 : row});
  }
  return group;
}

/// A result in the making: one group after another.
class Collector {
 public:
  explicit Collector(const State& s) : s_(s), precision_(s) {
    const Eigen::Index rows = s.data.observations();
    for (Vector* v : {&result_.predicted, &result_.variance, &result_.residual})
      *v = Vector::Constant(rows, kNaN);
  }

  void add(const Group& group) {
    const Dataset& data = s_.data;
    const double ratio = s_.covariance.noise_ratio;
    result_.groups.push_back({group.rows, {}});
    if (ratio == 0.0) check_whole_points(group);
    const Omitted out = omit(precision_, group.items);
    if (!out.defined) return;
    const double unit = data.scale * data.scale * s_.amplitude;
    const auto m = static_cast<Eigen::Index>(group.rows.size());
    Matrix covariance(m, m);
    for (Eigen::Index i = 0; i < m; ++i)
      for (Eigen::Index j = 0; j < m; ++j) covariance(i, j) = unit * row_entry(group, out, i, j);
    for (Eigen::Index i = 0; i < m; ++i) {
      const auto row = static_cast<std::size_t>(group.rows[static_cast<std::size_t>(i)]);
      const std::size_t item = group.item_of_row[static_cast<std::size_t>(i)];
      const Item& what = group.items[item];
      const double observed = what.row < 0 ? data.y[what.point] : data.value_of_row[row];
      const double mean = observed - out.residual[static_cast<Eigen::Index>(item)];
      store(row, {data.shift + data.scale * mean, covariance(i, i)});
    }
    result_.groups.back().covariance = std::move(covariance);
    result_.log_density += log_density(group, out);
  }

  LeftOut finish() {
    double total = 0.0;
    for (Eigen::Index i = 0; i < result_.residual.size(); ++i)
      if (!std::isnan(result_.residual[i]))
        total += std::pow(response(static_cast<std::size_t>(i)) - sum_ / defined_, 2);
    result_.q2 = total > 0.0 ? 1.0 - squares_ / total : kNaN;
    result_.rmse = defined_ > 0.0 ? std::sqrt(squares_ / defined_) : kNaN;
    result_.coverage95 = defined_ > 0.0 ? covered_ / defined_ : kNaN;
    return std::move(result_);
  }

 private:
  static void check_whole_points(const Group& group) {
    for (const Item& item : group.items)
      if (item.row >= 0)
        throw InputError(fmt::format(
            "row {} has repeats in another group; without noise they tell its value: put the "
            "repeats of a point in one group",
            item.row + 1));
  }

  double modelled_value(std::size_t row) const {
    return s_.data.shift + s_.data.scale * s_.data.value_of_row[row];
  }
  double response(std::size_t row) const {
    return unmodelled(s_.data.response_scale, modelled_value(row));
  }

  /// Covariance of the residuals of two rows of the group.
  double row_entry(const Group& group, const Omitted& out, Eigen::Index i, Eigen::Index j) const {
    const auto a = static_cast<std::size_t>(i);
    const auto b = static_cast<std::size_t>(j);
    const std::size_t ia = group.item_of_row[a];
    const std::size_t ib = group.item_of_row[b];
    double value = out.covariance(static_cast<Eigen::Index>(ia), static_cast<Eigen::Index>(ib));
    const Item& item = group.items[ia];
    if (ia != ib || item.row >= 0) return value;
    // the mean's own noise gives way to that of the observation; jitter is no variance
    const double ratio = s_.covariance.noise_ratio;
    value = std::max(0.0, value - ratio * s_.data.noise[item.point] - s_.factor.jitter);
    if (i == j) value += ratio * s_.data.noise_of_row[static_cast<std::size_t>(group.rows[a])];
    return value;
  }

  void store(std::size_t row, const Gaussian& modelled) {
    const auto i = static_cast<Eigen::Index>(row);
    const Gaussian natural = moments(s_.data.response_scale, modelled).y;
    const double y = response(row);
    result_.predicted[i] = natural.mean;
    result_.variance[i] = natural.variance;
    result_.residual[i] = y - natural.mean;
    defined_ += 1.0;
    sum_ += y;
    squares_ += result_.residual[i] * result_.residual[i];
    // intervals are those of the modelled scale; a constant response has neither residual nor
    // variance beyond rounding: covered
    const double difference = modelled_value(row) - modelled.mean;
    if (std::abs(difference) <= 1.959964 * modelled.standard_deviation() + 1e-12 * s_.data.scale)
      covered_ += 1.0;
  }

  /// Of all observations of the group, given the rest: of the items, and of the observations about
  /// the means of whole points.
  double log_density(const Group& group, const Omitted& out) const {
    const Dataset& data = s_.data;
    if (s_.amplitude == 0.0) return std::numeric_limits<double>::infinity();
    const double log_unit = std::log(2.0 * std::numbers::pi * s_.amplitude);
    const auto m = static_cast<double>(group.items.size());
    Vector qy(static_cast<Eigen::Index>(group.items.size()));
    for (Eigen::Index i = 0; i < qy.size(); ++i)
      qy[i] = precision_.times_y(group.items[static_cast<std::size_t>(i)]);
    double twice = m * log_unit + out.log_det + out.residual.dot(qy) / s_.amplitude;
    double jacobian = 0.0;
    double counted = m;
    const double ratio = s_.covariance.noise_ratio;
    for (std::size_t i = 0; i < group.rows.size(); ++i) {
      const auto row = static_cast<std::size_t>(group.rows[i]);
      const Item& item = group.items[group.item_of_row[i]];
      jacobian += log_jacobian(data.response_scale, response(row));
      if (item.row >= 0 || ratio == 0.0) continue;
      const double w = data.noise_of_row[row];
      twice +=
          log_unit + std::log(ratio * w) +
          std::pow(data.value_of_row[row] - data.y[item.point], 2) / (ratio * w * s_.amplitude);
      counted += 1.0;
    }
    if (ratio > 0.0)
      for (const Item& item : group.items)
        if (item.row < 0) {
          twice -= log_unit + std::log(ratio * data.noise[item.point]);
          counted -= 1.0;
        }
    return -0.5 * twice - counted * std::log(data.scale) + jacobian;
  }

  const State& s_;
  Precision precision_;
  LeftOut result_;
  double defined_ = 0.0;
  double sum_ = 0.0;
  double squares_ = 0.0;
  double covered_ = 0.0;
};

}  // namespace

LeftOut GaussianProcess::leave_groups_out(std::span<const Eigen::Index> groups) const {
  if (static_cast<Eigen::Index>(groups.size()) != rows())
    throw InputError(fmt::format("{} groups for {} rows; each row has one", groups.size(), rows()));
  std::map<Eigen::Index, Rows> members;
  for (std::size_t row = 0; row < groups.size(); ++row)
    members[groups[row]].push_back(static_cast<Eigen::Index>(row));
  Collector collector(*state_);
  for (auto& [group, rows_of_group] : members)
    collector.add(make_group(*state_, std::move(rows_of_group)));
  return collector.finish();
}

LeftOut GaussianProcess::leave_one_out() const {
  return leave_groups_out(state_->data.point_of_row);
}

}  // namespace repose::surrogate
