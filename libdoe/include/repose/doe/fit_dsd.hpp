// The two-stage analysis of definitive screening designs: main effects first, then the second-order
// effects of the active ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "repose/doe/anova.hpp"
#include "repose/doe/least_squares.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {

/// Which second-order terms the active main effects let in.
enum class Heredity {
  strong,  ///< all factors of the term must be active
  weak,    ///< one of them
  none,    ///< none: terms of inactive factors too
};

struct FitDsdOptions {
  /// Threshold of stage 1 by degrees of freedom of its error: one, two, more than two.
  double alpha_one_df = 0.20;
  double alpha_two_df = 0.10;
  double alpha_more_df = 0.05;
  /// Stage 2 stops adding terms once what is left compares with stage 1's error at p above this.
  double alpha_second = 0.20;
  Heredity interactions = Heredity::strong;
  Heredity quadratics = Heredity::strong;
  /// Stage 2 chooses this many terms at most; negative: half as many as there are pairs.
  int most_second_order = -1;
  /// Nodes of the searches for the best subsets of all sizes together; about 10 to 30 microseconds
  /// each. Beyond it the best subset met is kept, larger ones are greedy with exchanges, and
  /// Step::exact is false.
  std::int64_t search_budget = 20000;
};

struct FitDsdResult {
  int pairs = 0;  ///< complete fold-over pairs, m
  int centre_runs = 0;
  // Stage 1
  Vector main_effects;  ///< all factors' coefficients b
  Vector t;             ///< before pooling; NaN without error degrees of freedom
  Vector p;
  double fake_ss = 0.0;    ///< odd part of y not explained by main effects
  int fake_df = 0;         ///< pairs - factors
  double centre_ss = 0.0;  ///< pure error of the centre runs
  int centre_df = 0;
  double alpha = 0.0;       ///< threshold used
  std::vector<int> active;  ///< factors
  Vector active_t;  ///< of the active factors, after pooling the inactive ones into the error
  Vector active_p;
  double stage1_sigma = 0.0;  ///< after pooling the inactive main effects
  int stage1_df = 0;
  // Stage 2
  double second_ss = 0.0;  ///< of the even part of y about its mean (of blocks), without pure error
  int second_df = 0;
  double second_f = 0.0;
  double second_p = 1.0;
  struct Step {
    std::vector<Term> terms;  ///< the best subset of its size
    double residual_ss = 0.0;
    double f = 0.0;
    double p = 0.0;
    bool exact = true;       ///< no subset of this size leaves less
    std::int64_t nodes = 0;  ///< of the search
  };
  std::vector<Step> steps;
  std::vector<Term> second_order;  ///< chosen
  // Combined model: intercept, active main effects, chosen second-order terms, then blocks
  std::vector<int> runs;  ///< that it is fitted to: complete pairs and centre runs
  std::vector<Term> terms;
  LeastSquaresFit fit;
  std::vector<AnovaRow> anova;
};

/// [JonesNachtsheim2017], with the details of docs/methods/screening.md. `coded` must consist of
/// fold-over pairs and centre runs; single runs (a mirror image failed) are left out. `blocks`
/// numbers the block of each run, empty for none; both runs of a pair stand in one block, and
/// blocks are always in the model. Throws InputError if fewer pairs than factors remain, a pair is
/// split between blocks, an option is out of range or `y` is not finite.
FitDsdResult fit_definitive_screening(const Matrix& coded, const Vector& y,
                                      const std::vector<std::string>& factors,
                                      const FitDsdOptions& options = {},
                                      const std::vector<int>& blocks = {});

}  // namespace repose::doe
