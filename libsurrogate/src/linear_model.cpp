#include "repose/surrogate/linear_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "linear_state.hpp"
#include "minimum_norm.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/stepwise.hpp"

namespace repose::surrogate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// What is left of a row outside of the training rows' space, of its length, to count as asked for
/// something they do not determine.
constexpr double kOutsideRowSpace = 1e-6;
constexpr int kMaxReweightings = 50;
constexpr double kReweighted = 1e-8;               ///< change of the coefficients, of the largest
constexpr double kSmallestScale = 1e-6;            ///< of the robust scale, of the deviation of y
constexpr double kNormalMad = 0.6744897501960817;  ///< median of |normal|, deviation 1

Vector leverages(const Matrix& design, const MinimumNormFit& fit) {
  return (design * fit.root).rowwise().squaredNorm();
}

/// Of normal errors, from the absolute residuals without the p - 1 smallest, which p coefficients
/// make small.
double scale_of(const Vector& residual, Eigen::Index p) {
  std::vector<double> size(residual.size());
  for (std::size_t i = 0; i < size.size(); ++i)
    size[i] = std::abs(residual[static_cast<Eigen::Index>(i)]);
  std::sort(size.begin(), size.end());
  const auto first =
      std::min(static_cast<std::size_t>(std::max<Eigen::Index>(p - 1, 0)), size.size() - 1);
  const std::size_t n = size.size() - first;
  const double median = 0.5 * (size[first + (n - 1) / 2] + size[first + n / 2]);
  return median / kNormalMad;
}

double bisquare_weight(double u) {
  return std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
}

double deviation(const Vector& y) {
  return std::sqrt((y.array() - y.mean()).square().sum() /
                   static_cast<double>(std::max<Eigen::Index>(y.size() - 1, 1)));
}

/// What a fit by either method leaves in the state.
struct Fitted {
  MinimumNormFit fit;
  double error_variance = kNaN;
  double coefficient_variance = kNaN;
  int iterations = 1;
  bool converged = true;
};

Fitted least_squares(const Matrix& design, const Vector& y, const Vector& weights) {
  Fitted f{.fit = minimum_norm_fit(design, y, weights)};
  const double df = weights.sum() - static_cast<double>(f.fit.rank);
  if (df > 0.0) {
    const Vector residual = y - design * f.fit.coefficients;
    f.error_variance = residual.cwiseAbs2().dot(weights) / df;
    f.coefficient_variance = f.error_variance;
  }
  return f;
}

/// Variance of the errors and factor of (X^T X)^-1 in the coefficients' covariance, kappa^2
/// sum psi^2/(n - p)/mean(psi')^2 [Huber1981, 7.6.4], u = residual/(c s).
void set_robust_variances(Fitted& f, const Vector& u, double unit, Eigen::Index rank) {
  const auto n = static_cast<double>(u.size());
  const auto p = static_cast<double>(rank);
  double psi_square = 0.0;
  Vector slope(u.size());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double w = bisquare_weight(u[i]);
    psi_square += std::pow(unit * u[i] * w, 2);
    slope[i] = w > 0.0 ? (1.0 - u[i] * u[i]) * (1.0 - 5.0 * u[i] * u[i]) : 0.0;
  }
  const double mean = slope.mean();
  if (!(mean > 0.0)) return;  // too many outliers to tell
  const double spread = (slope.array() - mean).square().mean();
  const double kappa = 1.0 + p / n * spread / (mean * mean);
  f.coefficient_variance = kappa * kappa * psi_square / (n - p) / (mean * mean);
}

Fitted robust(const Matrix& design, const Vector& y, double constant) {
  Fitted f = least_squares(design, y, Vector::Ones(y.size()));
  const Eigen::Index rank = f.fit.rank;
  if (y.size() <= rank) return f;  // nothing is left that could be an outlier
  const MinimumNormFit plain = f.fit;
  const Vector adjust =
      (1.0 - leverages(design, plain).array().min(0.9999)).sqrt().inverse().matrix();
  const double smallest = kSmallestScale * deviation(y);
  if (smallest == 0.0) return f;
  f.converged = false;
  double scale = 0.0;
  Vector u;
  while (!f.converged && f.iterations < kMaxReweightings) {
    const Vector residual = (y - design * f.fit.coefficients).cwiseProduct(adjust);
    scale = std::max(scale_of(residual, rank), smallest);
    u = residual / (constant * scale);
    const Vector before = f.fit.coefficients;
    MinimumNormFit next = minimum_norm_fit(design, y, u.unaryExpr(&bisquare_weight));
    if (next.rank < rank) break;  // a coefficient would rest on outliers alone
    f.fit = std::move(next);
    f.converged = (f.fit.coefficients - before).cwiseAbs().maxCoeff() <=
                  kReweighted * f.fit.coefficients.cwiseAbs().maxCoeff();
    ++f.iterations;
  }
  f.error_variance = scale * scale;
  f.coefficient_variance = kNaN;
  set_robust_variances(f, u, constant * scale, rank);
  f.fit.root = plain.root;
  f.fit.row_space = plain.row_space;
  f.fit.rank = rank;
  return f;
}

/// The terms that stay, in the order of all.
std::vector<doe::Term> chosen_terms(const Matrix& coded, const Vector& y,
                                    const std::vector<doe::Term>& candidates,
                                    const LinearModelOptions& options) {
  if (candidates.empty() || y.size() < 3) return {};
  if (y.maxCoeff() == y.minCoeff()) return {};
  std::vector<std::string> names;
  for (Eigen::Index k = 0; k < coded.cols(); ++k) names.push_back(fmt::format("column {}", k + 1));
  auto chosen = doe::stepwise_regression(coded, y, names, candidates,
                                         {.p_enter = options.p_enter, .p_leave = options.p_leave})
                    .terms;
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

const char* to_string(LinearTerms terms) {
  constexpr const char* kNames[] = {"linear", "interactions"};
  return kNames[static_cast<int>(terms)];
}

const char* to_string(LinearMethod method) {
  constexpr const char* kNames[] = {"least-squares", "robust", "stepwise"};
  return kNames[static_cast<int>(method)];
}

LinearModel::LinearModel(std::shared_ptr<const State> state) : state_(std::move(state)) {}

LinearModel LinearModel::fit(const TrainingSet& data, const LinearModelOptions& options) {
  check(data);
  if (!(options.bisquare_constant > 0.0))
    throw InputError(
        fmt::format("the bisquare constant is {}; it must be positive", options.bisquare_constant));
  const bool weighted = data.weights.size() > 0;
  if (weighted && options.method != LinearMethod::least_squares)
    throw InputError(
        fmt::format("a {} linear model takes no weights; use least squares, or leave them out",
                    to_string(options.method)));
  const Vector& y = data.y;
  State s{.columns = CodedColumns(data.inputs)};
  const Matrix coded = s.columns.coded(data.x);
  s.terms = s.columns.terms(options.terms);
  if (options.method == LinearMethod::stepwise) s.terms = chosen_terms(coded, y, s.terms, options);
  const Matrix design = doe::model_matrix(coded, s.terms);
  Fitted f = options.method == LinearMethod::robust
                 ? robust(design, y, options.bisquare_constant)
                 : least_squares(design, y, weighted ? data.weights : Vector::Ones(y.size()));
  s.method = options.method;
  s.coefficients = std::move(f.fit.coefficients);
  s.root = std::move(f.fit.root);
  if (f.fit.rank < design.cols()) s.row_space = std::move(f.fit.row_space);
  s.error_variance = f.error_variance;
  s.coefficient_variance = f.coefficient_variance;
  s.report = {.coefficients = design.cols(),
              .rank = f.fit.rank,
              .residual_df = y.size() - f.fit.rank,
              .iterations = f.iterations,
              .converged = f.converged};
  return LinearModel(std::make_shared<const State>(std::move(s)));
}

const std::vector<Input>& LinearModel::inputs() const {
  return state_->columns.encoding().inputs();
}

const LinearFitReport& LinearModel::report() const {
  return state_->report;
}

std::vector<std::string> LinearModel::term_names(const std::vector<std::string>& inputs) const {
  return doe::column_names(state_->terms, state_->columns.names(inputs));
}

const Vector& LinearModel::coefficients() const {
  return state_->coefficients;
}

double LinearModel::error_variance() const {
  return state_->error_variance;
}

Vector LinearModel::predict(const Matrix& x) const {
  return state_->design(x) * state_->coefficients;
}

Predictions LinearModel::predict_with_variances(const Matrix& x) const {
  const State& s = *state_;
  const Matrix design = s.design(x);
  Predictions p{.mean = design * s.coefficients};
  p.function_variance = s.coefficient_variance * (design * s.root).rowwise().squaredNorm().array();
  if (s.row_space.size() > 0 && !std::isnan(s.coefficient_variance)) {
    const Matrix outside = design - (design * s.row_space) * s.row_space.transpose();
    for (Eigen::Index i = 0; i < design.rows(); ++i)
      if (outside.row(i).norm() > kOutsideRowSpace * design.row(i).norm())
        p.function_variance[i] = kInfinity;
  }
  p.observation_variance = p.function_variance.array() + s.error_variance;
  return p;
}

std::string LinearModel::describe() const {
  const LinearFitReport& r = state_->report;
  return fmt::format(
      "linear regression, {}, {} coefficients{}", to_string(state_->method), r.coefficients,
      r.rank < r.coefficients ? fmt::format(", {} of them aliased", r.coefficients - r.rank) : "");
}

Trainer linear_model_trainer(std::string name, const LinearModelOptions& options) {
  return {.name = std::move(name), .fit = [options](const TrainingSet& data, std::uint64_t) {
            return Regressor(LinearModel::fit(data, options));
          }};
}

}  // namespace repose::surrogate
