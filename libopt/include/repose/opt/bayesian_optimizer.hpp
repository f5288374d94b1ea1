// Bayesian optimisation by asking and telling: whoever runs the simulations does it when and where
// they like, and may stop in between.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "repose/opt/propose.hpp"
#include "repose/opt/search_space.hpp"

namespace repose::opt {

/// Surrogates of the columns of y (n x k) over the free parameters x (n x d, natural values), one
/// each. Must depend on its arguments only, or a state loaded from a file goes on otherwise.
using SurrogateFitter = std::function<std::vector<Surrogate>(const Matrix& x, const Matrix& y)>;

/// What is searched for: the smallest value of one response, or the smallest weighted error of
/// several.
struct OptimizationProblem {
  ParameterSpace parameters;
  std::vector<std::string> responses;
  std::vector<Target> targets = {};  ///< one for each response, in order; empty: minimise the one
};

struct BayesianOptimizationOptions {
  /// Quasi-random points before a surrogate has a say; 0: max(2 d + 2, 10), few as runs that can be
  /// chosen are worth more [LeRiche2021].
  int initial_points = 0;
  /// Its points and seed are filled in. Distances are of the range.
  ProposeOptions propose = {};
  std::uint64_t seed = 1;
};

enum class TrialState { pending, done, failed };
const char* to_string(TrialState state);

/// A point that was asked for.
struct Trial {
  std::int64_t id = 0;  ///< 1, 2, ... in the order of asking
  Vector x;             ///< free parameters, natural values
  TrialState state = TrialState::pending;
  Vector y;  ///< the responses, once done
  /// What it promised, as Proposal::merit; NaN of an initial point.
  double merit = std::numeric_limits<double>::quiet_NaN();
};

class BayesianOptimizer {
 public:
  /// Throws InputError on no response, targets that do not match them or are bad, a space that
  /// cannot be searched, and negative numbers in the options.
  BayesianOptimizer(OptimizationProblem problem, SurrogateFitter fitter,
                    BayesianOptimizationOptions options = {});

  /// `count` new trials: initial points first, then proposals by surrogates of all that was told.
  /// While what is done does not suffice for the fitter (it throws InputError, or fewer than two
  /// trials are done), more initial points. The same calls in the same order
  /// give the same bits, whatever was saved and loaded in between. Throws what the fitter throws;
  /// nothing has changed then.
  std::vector<Trial> ask(int count = 1);
  /// The responses of a pending trial. Throws InputError for an unknown or finished trial and
  /// values that are not finite.
  void tell(std::int64_t id, const Vector& y);
  /// The simulation of a pending trial failed: its neighbourhood is left alone.
  void tell_failed(std::int64_t id);
  /// A run that was made anyway, as a trial that is done. It may break constraints. Throws
  /// InputError as tell(), and for values that the parameters do not take.
  std::int64_t add(const Vector& x, const Vector& y);

  struct Recommendation {
    std::int64_t trial = 0;
    Vector x;
    Gaussian objective;  ///< posterior
  };
  /// The trial that is done with the smallest posterior mean of the objective; one that breaks a
  /// constraint only if all do. Throws InputError before one is done.
  Recommendation recommend() const;

  const OptimizationProblem& problem() const { return problem_; }
  const BayesianOptimizationOptions& options() const { return options_; }
  const std::vector<Trial>& trials() const { return trials_; }

  /// Everything but the fitter and the number of threads, in one HDF5 file of tables, atomically:
  /// attributes with the options (state_version 1), /parameters, /levels, /fixed, /ties,
  /// /constraints, /responses, /trials. Throws StorageError.
  void save(const std::filesystem::path& path) const;
  /// Throws StorageError for a file that is missing, damaged, something else or of a newer version.
  static BayesianOptimizer load(const std::filesystem::path& path, SurrogateFitter fitter);

 private:
  Trial& pending_trial(std::int64_t id);
  void check_response(const Vector& y) const;
  Matrix points_in(TrialState state) const;  ///< natural
  Matrix responses() const;
  Matrix initial_points(int count) const;
  std::vector<Surrogate> surrogates(const Matrix& done) const;
  Vector visited_at(const Vector& coordinates) const;

  OptimizationProblem problem_;
  SearchSpace space_;
  SurrogateFitter fitter_;
  BayesianOptimizationOptions options_;
  std::vector<Trial> trials_;
  std::int64_t initial_asked_ = 0;
};

}  // namespace repose::opt
