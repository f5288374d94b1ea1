// What stands in for a simulation: predicts, and can be told a value without being fitted again.
#pragma once

#include <concepts>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "repose/base/gaussian.hpp"
#include "repose/base/parameter_space.hpp"

namespace repose::opt {

/// Mean and standard deviation at a point and their derivatives in its d coordinates.
struct PredictionGradient {
  Gaussian function;
  Vector mean;
  Vector standard_deviation;  ///< 0 where the standard deviation is
};

template <class S>
concept SurrogateLike = requires(const S& s, const Vector& x, const Matrix& rows, double y) {
  { s.predict(x) } -> std::convertible_to<Gaussian>;
  { s.predict_rows(rows) } -> std::convertible_to<std::vector<Gaussian>>;
  { s.condition_on(x, y) } -> std::convertible_to<S>;
};

/// Needed for climbing by gradients; without it, methods that need none are used.
template <class S>
concept HasGradient = requires(const S& s, const Vector& x) {
  { s.predict_gradient(x) } -> std::convertible_to<PredictionGradient>;
};

/// Needed where several points must be judged together (noisy expected improvement, deliberate
/// repeats): covariance(a, b), m x p, between the function at the rows of a and of b.
template <class S>
concept HasCovariance = requires(const S& s, const Matrix& rows) {
  { s.covariance(rows, rows) } -> std::convertible_to<Matrix>;
};

/// Any surrogate as a value; copies share the model, which never changes.
class Surrogate {
 public:
  template <SurrogateLike S>
  requires(!std::same_as<std::remove_cvref_t<S>, Surrogate>) Surrogate(S model)
      : model_(std::make_shared<const Model<S>>(std::move(model))) {}

  Gaussian predict(const Vector& x) const { return model_->predict(x); }
  std::vector<Gaussian> predict_rows(const Matrix& rows) const {
    return model_->predict_rows(rows);
  }
  Surrogate condition_on(const Vector& x, double y) const { return model_->condition_on(x, y); }

  bool has_gradient() const { return model_->has_gradient(); }
  /// Throws Error (internal) unless has_gradient().
  PredictionGradient predict_gradient(const Vector& x) const { return model_->predict_gradient(x); }
  bool has_covariance() const { return model_->has_covariance(); }
  /// Throws Error (internal) unless has_covariance().
  Matrix covariance(const Matrix& a, const Matrix& b) const { return model_->covariance(a, b); }

 private:
  [[noreturn]] static void refuse(const char* what);
  struct Interface {
    virtual ~Interface() = default;
    virtual Gaussian predict(const Vector& x) const = 0;
    virtual std::vector<Gaussian> predict_rows(const Matrix& rows) const = 0;
    virtual Surrogate condition_on(const Vector& x, double y) const = 0;
    virtual bool has_gradient() const = 0;
    virtual PredictionGradient predict_gradient(const Vector& x) const = 0;
    virtual bool has_covariance() const = 0;
    virtual Matrix covariance(const Matrix& a, const Matrix& b) const = 0;
  };
  template <class S>
  struct Model final : Interface {
    explicit Model(S s) : model(std::move(s)) {}
    Gaussian predict(const Vector& x) const override { return model.predict(x); }
    std::vector<Gaussian> predict_rows(const Matrix& rows) const override {
      return model.predict_rows(rows);
    }
    Surrogate condition_on(const Vector& x, double y) const override {
      return Surrogate(S(model.condition_on(x, y)));
    }
    bool has_gradient() const override {
      if constexpr (requires(const S& s) { s.has_gradient(); })
        return model.has_gradient();
      else
        return HasGradient<S>;
    }
    PredictionGradient predict_gradient(const Vector& x) const override {
      if constexpr (HasGradient<S>)
        return model.predict_gradient(x);
      else
        refuse("gradient");
    }
    bool has_covariance() const override {
      if constexpr (requires(const S& s) { s.has_covariance(); })
        return model.has_covariance();
      else
        return HasCovariance<S>;
    }
    Matrix covariance(const Matrix& a, const Matrix& b) const override {
      if constexpr (HasCovariance<S>)
        return model.covariance(a, b);
      else
        refuse("covariance");
    }
    S model;
  };
  std::shared_ptr<const Interface> model_;
};

}  // namespace repose::opt
