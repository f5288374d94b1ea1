#include <fmt/format.h>
#include <libsvm/svm.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "repose/base/error.hpp"
#include "svr_state.hpp"

namespace repose::surrogate {
namespace {

constexpr double kIqrOfNormal = 1.349;  // in deviations, as MATLAB rounds it

void check_options(const SvrOptions& o) {
  const auto positive = [](double value, const char* name) {
    if (!(value > 0.0) || !std::isfinite(value))
      throw InputError(fmt::format(
          "support vector regression: the {} is {}; it must be positive and finite", name, value));
  };
  positive(o.kernel_scale, "kernel scale");
  positive(o.box_constraint, "box constraint");
  if (!(o.epsilon >= 0.0) || !std::isfinite(o.epsilon))
    throw InputError(fmt::format(
        "support vector regression: epsilon is {}; it must be 0 or positive", o.epsilon));
  if (!(o.tolerance >= 1e-6 && o.tolerance <= 0.1))
    throw InputError(fmt::format(
        "support vector regression: the tolerance is {}; it must be in [1e-6, 0.1]", o.tolerance));
}

/// Linear between order statistics at (i - 1/2)/n, as MATLAB's iqr.
double quantile(const std::vector<double>& sorted, double p) {
  const double place = p * static_cast<double>(sorted.size()) - 0.5;
  if (place <= 0.0) return sorted.front();
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 >= sorted.size()) return sorted.back();
  const double part = place - static_cast<double>(below);
  return sorted[below] + part * (sorted[below + 1] - sorted[below]);
}

/// 0 for a constant.
double robust_deviation(const Vector& y) {
  std::vector<double> sorted(y.begin(), y.end());
  std::sort(sorted.begin(), sorted.end());
  if (sorted.front() == sorted.back()) return 0.0;
  const double iqr = quantile(sorted, 0.75) - quantile(sorted, 0.25);
  if (iqr > 0.0) return iqr / kIqrOfNormal;
  return std::sqrt((y.array() - y.mean()).square().sum() / static_cast<double>(y.size() - 1));
}

int degree_of(SvrKernel kernel) {
  return kernel == SvrKernel::quadratic ? 2 : 3;
}

/// Kernel values of coordinates divided by the kernel scale: a.rows() x b.rows().
Matrix kernel_matrix(SvrKernel kernel, const Matrix& a, const Matrix& b) {
  const Matrix product = a * b.transpose();
  switch (kernel) {
    case SvrKernel::linear:
      return product;
    case SvrKernel::quadratic:
      return (1.0 + product.array()).square();
    case SvrKernel::cubic:
      return (1.0 + product.array()).cube();
    case SvrKernel::gaussian:
      break;
  }
  const Vector squares_a = a.rowwise().squaredNorm(), squares_b = b.rowwise().squaredNorm();
  const Matrix distance = (-2.0 * product).colwise() + squares_a;
  return (-(distance.rowwise() + squares_b.transpose()).array().max(0.0)).exp();
}

svm_parameter parameter_of(const SvrOptions& o) {
  svm_parameter p{};
  p.svm_type = EPSILON_SVR;
  p.kernel_type = o.kernel == SvrKernel::linear     ? LINEAR
                  : o.kernel == SvrKernel::gaussian ? RBF
                                                    : POLY;
  p.degree = degree_of(o.kernel);
  p.gamma = 1.0;  // the vectors are divided by the kernel scale
  p.coef0 = 1.0;
  p.cache_size = 64.0;  // MB
  p.eps = o.tolerance;
  p.C = o.box_constraint;
  p.p = o.epsilon;
  p.shrinking = 1;
  return p;
}

/// The rows of z as LIBSVM has them: lists of (column from 1, value), ended by -1.
class Problem {
 public:
  Problem(const Matrix& z, const Vector& y) : y_(y.begin(), y.end()) {
    nodes_.resize(static_cast<std::size_t>(z.rows() * (z.cols() + 1)));
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < z.rows(); ++i) {
      rows_.push_back(&nodes_[next]);
      for (Eigen::Index k = 0; k < z.cols(); ++k)
        nodes_[next++] = {static_cast<int>(k + 1), z(i, k)};
      nodes_[next++] = {-1, 0.0};
    }
    problem_ = {static_cast<int>(z.rows()), y_.data(), rows_.data()};
  }
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;
  const svm_problem& get() const { return problem_; }

 private:
  std::vector<double> y_;
  std::vector<svm_node> nodes_;
  std::vector<svm_node*> rows_;
  svm_problem problem_{};
};

struct FreeModel {
  void operator()(svm_model* model) const { svm_free_and_destroy_model(&model); }
};

/// Fills in vectors, weights and offset. LIBSVM's training draws no random numbers and keeps no
/// state but where it prints to. At its limit of 1e7 steps it warns on standard error, past the
/// hook that silences the rest, and hands back what it has: not to be told from a finished fit.
void train(SvrAccess::State& s, const Matrix& z, const Vector& y, const SvrOptions& options) {
  [[maybe_unused]] static const bool kSilent =
      (svm_set_print_string_function([](const char*) {}), true);
  const Problem problem(z, y);
  const svm_parameter parameter = parameter_of(options);
  if (const char* wrong = svm_check_parameter(&problem.get(), &parameter))
    throw InputError(fmt::format("support vector regression: {}", wrong));
  const std::unique_ptr<svm_model, FreeModel> model(svm_train(&problem.get(), &parameter));
  const Eigen::Index count = model->l;
  s.vectors.resize(count, z.cols());
  s.weights.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    s.vectors.row(i) = z.row(model->sv_indices[i] - 1);
    s.weights[i] = model->sv_coef[0][i];
  }
  s.offset = -model->rho[0];
}

}  // namespace

const char* to_string(SvrKernel kernel) {
  constexpr const char* kNames[] = {"linear", "quadratic", "cubic", "gaussian"};
  return kNames[static_cast<int>(kernel)];
}

SupportVectorRegression::SupportVectorRegression(std::shared_ptr<const State> state)
    : state_(std::move(state)) {}

SupportVectorRegression SupportVectorRegression::fit(const TrainingSet& data,
                                                     const SvrOptions& options) {
  check(data);
  if (data.weights.size() > 0)
    throw InputError("support vector regression takes no weights; leave them out");
  check_options(options);
  const Vector& y = data.y;
  State s{.columns = options.standardisation == Standardisation::none
                         ? StandardisedColumns::none(data.inputs)
                         : StandardisedColumns::of(data),
          .kernel = options.kernel,
          .shift = y.mean()};
  s.kernel_scale = options.kernel_scale *
                   std::sqrt(static_cast<double>(std::max<Eigen::Index>(s.columns.count(), 1)));
  const Matrix z = s.columns.columns(data.x) / s.kernel_scale;
  s.vectors.resize(0, z.cols());
  const double deviation = robust_deviation(y);
  if (deviation > 0.0) {
    s.scale = deviation;
    train(s, z, (y.array() - s.shift) / s.scale, options);
  } else {
    s.shift = y[0];
  }
  return SupportVectorRegression(std::make_shared<const State>(std::move(s)));
}

const std::vector<Input>& SupportVectorRegression::inputs() const {
  return state_->columns.inputs();
}

SvrKernel SupportVectorRegression::kernel() const {
  return state_->kernel;
}

Eigen::Index SupportVectorRegression::support_vectors() const {
  return state_->weights.size();
}

Vector SupportVectorRegression::predict(const Matrix& x) const {
  const State& s = *state_;
  const Matrix z = s.columns.columns(x) / s.kernel_scale;
  const Vector sum = kernel_matrix(s.kernel, z, s.vectors) * s.weights;
  return s.shift + s.scale * (sum.array() + s.offset);
}

std::string SupportVectorRegression::describe() const {
  return fmt::format("support vectors, {} kernel of scale {:.4g}, {} vectors",
                     to_string(state_->kernel), state_->kernel_scale, state_->weights.size());
}

Trainer svr_trainer(std::string name, const SvrOptions& options) {
  return {.name = std::move(name), .fit = [options](const TrainingSet& data, std::uint64_t) {
            return Regressor(SupportVectorRegression::fit(data, options));
          }};
}

}  // namespace repose::surrogate
