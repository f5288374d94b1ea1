// A fitted model of any kind as a value: what cross-validation, comparison, prediction and model
// files work with.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "repose/surrogate/training_set.hpp"

namespace repose::surrogate {

/// Of m points: m values each, or none where the model cannot tell that variance.
struct Predictions {
  Vector mean = {};
  Vector function_variance = {};     ///< of the function about its mean, noise not included
  Vector observation_variance = {};  ///< of a new observation, noise included
};

/// predict: m means from m x d inputs in natural units; throws InputError where an input has no
/// such value. describe: a line that says what was fitted, with the settings that were used or
/// found: "100 bagged trees, minimum leaf 5, 6 of 18 predictors a split".
template <class M>
concept RegressorLike = requires(const M& m, const Matrix& x) {
  { m.predict(x) } -> std::convertible_to<Vector>;
  { m.inputs() } -> std::convertible_to<const std::vector<Input>&>;
  { m.describe() } -> std::convertible_to<std::string>;
};

template <class M>
concept HasVariances = requires(const M& m, const Matrix& x) {
  { m.predict_with_variances(x) } -> std::convertible_to<Predictions>;
};

/// Any fitted model; never unfitted. Cheap to copy: copies share the model, which never changes.
/// As safe to use from several threads as the model is; all of ours are.
class Regressor {
 public:
  template <RegressorLike M>
  requires(!std::same_as<std::remove_cvref_t<M>, Regressor>) Regressor(M model)
      : model_(std::make_shared<const Model<M>>(std::move(model))) {}

  Vector predict(const Matrix& x) const { return model_->predict(x); }
  bool has_variances() const { return model_->has_variances(); }
  /// Means alone where the model has no variances.
  Predictions predict_with_variances(const Matrix& x) const {
    return model_->predict_with_variances(x);
  }
  const std::vector<Input>& inputs() const { return model_->inputs(); }
  Eigen::Index dimension() const { return static_cast<Eigen::Index>(inputs().size()); }
  std::string describe() const { return model_->describe(); }

  /// The model itself if it is an M, else nullptr; valid as long as a copy of this.
  template <RegressorLike M>
  const M* target() const {
    const auto* found = dynamic_cast<const Model<M>*>(model_.get());
    return found == nullptr ? nullptr : &found->model;
  }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual Vector predict(const Matrix& x) const = 0;
    virtual bool has_variances() const = 0;
    virtual Predictions predict_with_variances(const Matrix& x) const = 0;
    virtual const std::vector<Input>& inputs() const = 0;
    virtual std::string describe() const = 0;
  };
  template <class M>
  struct Model final : Interface {
    explicit Model(M m) : model(std::move(m)) {}
    Vector predict(const Matrix& x) const override { return model.predict(x); }
    bool has_variances() const override { return HasVariances<M>; }
    Predictions predict_with_variances(const Matrix& x) const override {
      if constexpr (HasVariances<M>)
        return model.predict_with_variances(x);
      else
        return {.mean = model.predict(x)};
    }
    const std::vector<Input>& inputs() const override { return model.inputs(); }
    std::string describe() const override { return model.describe(); }
    M model;
  };
  std::shared_ptr<const Interface> model_;
};

/// A way to fit, its settings bound: what cross-validation repeats and a comparison ranks.
struct Trainer {
  std::string name;
  /// The same data and seed give the same bits. Throws InputError for data it cannot be fitted to.
  std::function<Regressor(const TrainingSet& data, std::uint64_t seed)> fit;
};

}  // namespace repose::surrogate
