// The best subset of candidate columns for a linear model, by branch and bound.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

struct BestSubset {
  std::vector<int> columns;  ///< of the candidates, ascending
  double residual_ss = 0.0;
  bool exact = true;  ///< false: the budget ran out, this is the best subset met
  std::int64_t nodes = 0;
};

/// Explains y by `base` and some of `candidates`. Search in the manner of [FurnivalWilson1974]: a
/// branch is left if what all columns still free would leave, or a bound on what the `size` best of
/// them can explain given how far they are from orthogonal, cannot beat the best subset met.
class SubsetSearch {
 public:
  /// Columns of `base` that depend on others are ignored.
  SubsetSearch(const Vector& y, const Matrix& base, Matrix candidates);

  double residual_ss_of_base() const { return residual_.squaredNorm(); }
  int residual_df_of_base() const { return base_df_; }

  /// Nothing if no `size` candidates are linearly independent. `budget` is the number of nodes of
  /// the search tree, 0 for none: then the subset is greedy, improved by exchanges. `near` is a
  /// subset of size - 1 to begin with.
  std::optional<BestSubset> best(int size, std::int64_t budget, const std::vector<int>& near);

 private:
  struct Node {
    Vector residual;
    Matrix columns;          // what base and the columns chosen leave of the candidates still free
    std::vector<int> index;  // of those candidates
  };

  void search(Node node, int missing, std::vector<int>& chosen);
  Node child(const Node& node, const std::vector<Eigen::Index>& order, std::size_t position) const;
  std::vector<double> lower_bounds(const Node& node, const std::vector<Eigen::Index>& order,
                                   const Vector& explained, int missing) const;
  void greedy(int size, const std::vector<int>& near);
  void keep_if_better(std::vector<int> columns, double residual_ss);
  double residual_ss_with(const std::vector<int>& columns) const;

  Matrix base_;        // orthonormal
  Vector residual_;    // of y after base
  Matrix candidates_;  // orthogonal to base
  Vector full_norm_;   // squared, of the candidates as given
  int base_df_ = 0;
  BestSubset best_;
  std::int64_t budget_ = 0;
};

}  // namespace repose::doe
