// D-optimal designs, alone or added to runs that exist already.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {

enum class ModelOrder {
  linear,        ///< intercept and main effects
  interactions,  ///< and interactions of two factors
  quadratic,     ///< and quadratics
};

/// The terms of a model in `factors` factors. Factors in `two_level` (numbered from 0) have no
/// quadratic.
std::vector<Term> terms_of(ModelOrder order, int factors, const std::vector<int>& two_level = {});

/// Whether a run, in coded units, may be made; empty: every run.
using RunFilter = std::function<bool(const Vector& coded)>;

struct OptimalDesignOptions {
  /// Coded levels that each factor may take, ascending in [-1, 1]; one list a factor. Empty: -1, 1
  /// where the terms have no quadratic, else -1, 0, 1.
  std::vector<std::vector<double>> levels = {};
  /// Runs that are kept, rows before the new ones. Their levels may be any.
  Matrix existing = {};
  RunFilter allowed = {};
  /// Random starts, of which the best result is kept; >= 1.
  int starts = 10;
  /// Of one start, over all new runs; >= 1. Convergence usually takes fewer than 10.
  int max_passes = 100;
  std::uint64_t seed = 1;
};

struct OptimalDesign {
  Matrix coded;  ///< existing rows first, then the new runs
  /// |X^T X|^(1/p) / runs, p columns: 1 for an orthogonal two-level design.
  double d_efficiency = 0.0;
  std::vector<double> efficiencies;  ///< of each start; their spread shows whether more are needed
  int passes = 0;                    ///< of the best start
};

/// `runs` new runs that make |X^T X| of the model large, X = model_matrix(coded, terms): coordinate
/// exchange [MeyerNachtsheim1995], one coordinate of one run at a time set to the level that raises
/// the determinant most, as long as one does. A local optimum of each start; the global one is not
/// guaranteed. Cost of a pass: runs x factors x levels x p^2. Throws InputError if sizes do not
/// fit, if existing and new runs together are fewer than columns, if hardly any run is allowed, or
/// if the levels cannot estimate the terms.
OptimalDesign d_optimal_design(int factors, int runs, const std::vector<Term>& terms,
                               const OptimalDesignOptions& options = {});

/// |X^T X|^(1/p) / runs of any design for a model; 0 if X has not full rank.
double d_efficiency(const Matrix& coded, const std::vector<Term>& terms);

}  // namespace repose::doe
