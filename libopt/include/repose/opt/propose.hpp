// The next points to simulate: batches that maximise expected improvement, one believed after
// another.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "repose/base/gaussian.hpp"
#include "repose/base/parameter_space.hpp"
#include "repose/opt/composite.hpp"

namespace repose::opt {

/// Something that predicts and can be told one more value without being fitted again.
template <class S>
concept SurrogateLike = requires(const S& s, const Vector& x, const Matrix& rows, double y) {
  { s.predict(x) } -> std::convertible_to<Gaussian>;
  { s.predict_rows(rows) } -> std::convertible_to<std::vector<Gaussian>>;
  { s.condition_on(x, y) } -> std::convertible_to<S>;
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

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual Gaussian predict(const Vector& x) const = 0;
    virtual std::vector<Gaussian> predict_rows(const Matrix& rows) const = 0;
    virtual Surrogate condition_on(const Vector& x, double y) const = 0;
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
    S model;
  };
  std::shared_ptr<const Interface> model_;
};

/// Whether a batch may repeat a point: useless for a deterministic simulation, legitimate for a
/// noisy one.
enum class Repeats { avoid, allow };

struct ProposeOptions {
  /// Points (rows, unit coordinates) whose values the surrogates know. The incumbent is the
  /// smallest posterior mean of the objective among them, never the luckiest observation.
  Matrix visited;
  /// Points that are being simulated: believed to be what the surrogates predict.
  Matrix pending;
  /// Points whose simulation failed: no value is known there and none is believed; proposals keep
  /// failed_distance (largest coordinate difference) away from them.
  Matrix failed;
  double failed_distance = 0.1;
  Repeats repeats = Repeats::avoid;
  /// Largest coordinate difference below which two points are the same, for Repeats::avoid.
  double minimum_distance = 1e-3;
  int candidates = 2000;         ///< quasi-random points tried first
  int polished = 5;              ///< of them climbed from, by bobyqa
  int polish_evaluations = 200;  ///< for each
  int draws = 256;               ///< of composite expected improvement
  std::uint64_t seed = 1;
  unsigned threads = 1;  ///< the result does not depend on it
};

struct Proposal {
  Matrix points;                        ///< q x d, unit coordinates
  std::vector<Gaussian> predicted;      ///< objective at each, when it was chosen
  std::vector<double> log_improvement;  ///< log expected improvement at each, when it was chosen
};

/// q points of the unit cube of dimension d that promise to lower one modelled quantity: log
/// expected improvement maximised from the best of many candidates, the posterior mean taken for
/// the value there (Kriging believer [Ginsbourger2010]), and again. `objective` takes unit
/// coordinates. Throws InputError on q < 1 or matrices without d columns.
Proposal propose_batch(const Surrogate& objective, Eigen::Index dimension, int q,
                       const ProposeOptions& options);

/// The same for the weighted error of several quantities, kpis[j] predicting what targets[j] wants:
/// composite expected improvement [Astudillo2019], believing at the level of the quantities.
Proposal propose_batch(std::span<const Surrogate> kpis, std::span<const Target> targets,
                       Eigen::Index dimension, int q, const ProposeOptions& options);

}  // namespace repose::opt
