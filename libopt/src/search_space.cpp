#include "repose/opt/search_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

constexpr double kRounding = 1e-12;

/// a . x + offset of the free parameters x.
struct Affine {
  Vector slope;
  double offset = 0.0;
};

/// A constraint in terms of the free parameters: affine, since ties are means.
Affine in_free_parameters(const LinearConstraint& constraint, const ParameterSpace& space) {
  const auto d = static_cast<Eigen::Index>(space.dimension());
  const auto value = [&](const Vector& x) {
    const ParameterValues all = space.complete(x);
    double sum = 0.0;
    for (const auto& [name, coefficient] : constraint.coefficients)
      sum += coefficient * all.at(name);
    return sum;
  };
  Affine affine{.slope = Vector(d), .offset = value(Vector::Zero(d))};
  for (Eigen::Index k = 0; k < d; ++k) {
    Vector unit = Vector::Zero(d);
    unit[k] = 1.0;
    affine.slope[k] = value(unit) - affine.offset;
  }
  return affine;
}

bool equally_spaced(const std::vector<double>& levels) {
  const double step = (levels.back() - levels.front()) / static_cast<double>(levels.size() - 1);
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (std::abs(levels[i] - levels[0] - static_cast<double>(i) * step) > 1e-9 * step) return false;
  return true;
}

class MappedSurrogate {
 public:
  MappedSurrogate(Surrogate inner, std::function<Vector(const Vector&)> map,
                  std::function<Matrix(const Vector&)> jacobian)
      : inner_(std::move(inner)), map_(std::move(map)), jacobian_(std::move(jacobian)) {}

  Gaussian predict(const Vector& z) const { return inner_.predict(map_(z)); }
  std::vector<Gaussian> predict_rows(const Matrix& z) const { return inner_.predict_rows(rows(z)); }
  MappedSurrogate condition_on(const Vector& z, double y) const {
    return {inner_.condition_on(map_(z), y), map_, jacobian_};
  }
  bool has_gradient() const { return inner_.has_gradient(); }
  PredictionGradient predict_gradient(const Vector& z) const {
    PredictionGradient g = inner_.predict_gradient(map_(z));
    const Matrix j = jacobian_(z);
    g.mean = (j.transpose() * g.mean).eval();
    g.standard_deviation = (j.transpose() * g.standard_deviation).eval();
    return g;
  }
  bool has_covariance() const { return inner_.has_covariance(); }
  Matrix covariance(const Matrix& a, const Matrix& b) const {
    return inner_.covariance(rows(a), rows(b));
  }

 private:
  Matrix rows(const Matrix& z) const {
    Matrix x;
    for (Eigen::Index i = 0; i < z.rows(); ++i) {
      const Vector row = map_(z.row(i));
      if (i == 0) x.resize(z.rows(), row.size());
      x.row(i) = row;
    }
    return x;
  }

  Surrogate inner_;
  std::function<Vector(const Vector&)> map_;
  std::function<Matrix(const Vector&)> jacobian_;
};

}  // namespace

Surrogate mapped_surrogate(const Surrogate& inner, std::function<Vector(const Vector& z)> map,
                           std::function<Matrix(const Vector& z)> jacobian) {
  return MappedSurrogate(inner, std::move(map), std::move(jacobian));
}

SearchSpace::SearchSpace(ParameterSpace parameters) : parameters_(std::move(parameters)) {
  const auto& free = parameters_.parameters();
  const auto d = static_cast<Eigen::Index>(free.size());
  std::vector<Affine> affine;
  for (const LinearConstraint& c : parameters_.constraints())
    affine.push_back(in_free_parameters(c, parameters_));
  set_.bounds = {Vector(d), Vector(d)};
  for (Eigen::Index k = 0; k < d; ++k) {
    const Parameter& p = free[static_cast<std::size_t>(k)];
    const bool constrained = std::any_of(affine.begin(), affine.end(),
                                         [k](const Affine& a) { return a.slope[k] != 0.0; });
    const bool list = p.kind == ParameterKind::levels || p.kind == ParameterKind::categorical;
    Kind kind = list ? Kind::level : Kind::natural;
    if (p.kind == ParameterKind::continuous && p.scale == Scale::log && !constrained)
      kind = Kind::logarithm;
    kinds_.push_back(kind);
    if (list || p.kind == ParameterKind::integer) set_.whole.push_back(k);
    set_.bounds.lower[k] = list ? 0.0 : kind == Kind::logarithm ? std::log(p.lower) : p.lower;
    set_.bounds.upper[k] = list                      ? static_cast<double>(level_count(p) - 1)
                           : kind == Kind::logarithm ? std::log(p.upper)
                                                     : p.upper;
  }
  for (std::size_t c = 0; c < affine.size(); ++c) {
    const LinearConstraint& constraint = parameters_.constraints()[c];
    Affine& a = affine[c];
    for (Eigen::Index k = 0; k < d; ++k) {
      const Parameter& p = free[static_cast<std::size_t>(k)];
      if (p.kind != ParameterKind::levels || a.slope[k] == 0.0) continue;
      if (!equally_spaced(p.levels))
        throw InputError(fmt::format(
            "constraint {} holds {}, whose levels are not equally spaced; only equally spaced ones "
            "can be searched under a constraint",
            constraint.name, p.name));
      a.offset += a.slope[k] * p.levels.front();
      a.slope[k] *= (p.levels.back() - p.levels.front()) / set_.bounds.upper[k];
    }
    // the offset may be large beside what is left: what counts as rounding is of its size
    const auto bound = [&](double limit) {
      return limit + kRounding * (std::abs(limit) + std::abs(a.offset));
    };
    if (std::isfinite(constraint.upper))
      set_.inequalities.push_back({constraint.name, a.slope, bound(constraint.upper) - a.offset});
    if (std::isfinite(constraint.lower))
      set_.inequalities.push_back({constraint.name, -a.slope, a.offset + bound(-constraint.lower)});
  }
  check_feasible_set(set_);
}

Vector SearchSpace::natural(const Vector& coordinates) const {
  Vector x = rounded(coordinates, set_);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Parameter& p = parameters_.parameters()[i];
    if (kinds_[i] == Kind::logarithm)
      x[k] = std::clamp(std::exp(x[k]), p.lower, p.upper);
    else if (kinds_[i] == Kind::level && p.kind == ParameterKind::levels)
      x[k] = p.levels[static_cast<std::size_t>(x[k])];
  }
  return x;
}

Vector SearchSpace::coordinates(const Vector& natural) const {
  if (natural.size() != dimension())
    throw InputError(fmt::format("a point of {} values; the space has {} parameters",
                                 natural.size(), dimension()));
  Vector z = natural;
  for (Eigen::Index k = 0; k < z.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Parameter& p = parameters_.parameters()[i];
    if (kinds_[i] == Kind::logarithm) {
      if (!(z[k] > 0.0))
        throw InputError(fmt::format("{} is {}; on a log scale it must be positive", p.name, z[k]));
      z[k] = std::log(z[k]);
    } else if (kinds_[i] == Kind::level && p.kind == ParameterKind::levels) {
      const auto nearest = std::min_element(
          p.levels.begin(), p.levels.end(),
          [&](double a, double b) { return std::abs(a - natural[k]) < std::abs(b - natural[k]); });
      z[k] = static_cast<double>(nearest - p.levels.begin());
    }
  }
  return z;
}

Matrix SearchSpace::natural_rows(const Matrix& coordinates) const {
  Matrix x(coordinates.rows(), dimension());
  for (Eigen::Index i = 0; i < x.rows(); ++i) x.row(i) = natural(coordinates.row(i));
  return x;
}

Matrix SearchSpace::coordinates_rows(const Matrix& natural) const {
  Matrix z(natural.rows(), dimension());
  for (Eigen::Index i = 0; i < z.rows(); ++i) z.row(i) = coordinates(natural.row(i));
  return z;
}

Vector SearchSpace::derivative(const Vector& coordinates) const {
  Vector d = Vector::Ones(coordinates.size());
  for (Eigen::Index k = 0; k < d.size(); ++k)
    if (kinds_[static_cast<std::size_t>(k)] == Kind::logarithm) d[k] = std::exp(coordinates[k]);
  for (const Eigen::Index k : set_.whole) d[k] = 0.0;
  return d;
}

Surrogate SearchSpace::in_coordinates(const Surrogate& surrogate) const {
  const auto space = std::make_shared<const SearchSpace>(*this);  // copied with every belief
  return mapped_surrogate(
      surrogate, [space](const Vector& z) { return space->natural(z); },
      [space](const Vector& z) { return Matrix(space->derivative(z).asDiagonal()); });
}

}  // namespace repose::opt
