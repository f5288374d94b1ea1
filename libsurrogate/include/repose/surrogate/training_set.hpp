// What models are fitted to: rows of inputs with a response, and which rows belong together.
#pragma once

#include <span>
#include <vector>

#include "repose/surrogate/input.hpp"

namespace repose::surrogate {

struct TrainingSet {
  Matrix x;                   ///< n x d in natural units, levels of categories as their numbers
  Vector y;                   ///< n
  std::vector<Input> inputs;  ///< d
  /// How much each row counts, > 0; as many repeats of the row would. Empty: all the same.
  Vector weights = {};
  /// Of each row, any number: a material, a laboratory. Empty: none known.
  std::vector<Eigen::Index> groups = {};
  /// Rows with equal number repeat one point: what resamples or divides rows keeps them together.
  /// Empty: rows with equal x do.
  std::vector<Eigen::Index> replicates = {};

  Eigen::Index rows() const { return x.rows(); }
  Eigen::Index dimension() const { return static_cast<Eigen::Index>(inputs.size()); }
};

/// Throws InputError on no rows, on lengths that differ, on weights that are not positive, and
/// naming row and column on values that are not finite or that an input cannot have.
void check(const TrainingSet& data);

/// These rows in this order, with all that belongs to them; a row may repeat.
TrainingSet selected_rows(const TrainingSet& data, std::span<const Eigen::Index> rows);

}  // namespace repose::surrogate
