// Standardised columns in files of models.
#pragma once

#include "model_content.hpp"
#include "standardised.hpp"

namespace repose::surrogate {

/// /columns: shift, factor of each coordinate.
inline table::Table columns_table(const StandardisedColumns& columns) {
  table::Table t;
  add_column(t, "shift", doubles(columns.shift()));
  add_column(t, "factor", doubles(columns.factor()));
  return t;
}

inline StandardisedColumns read_columns(const ModelReader& file, std::vector<Input> inputs) {
  const table::Table t = file.read("/columns");
  const Eigen::Index expected = StandardisedColumns::none(inputs).count();
  file.check(static_cast<Eigen::Index>(t.rows()) == expected, "/columns has the wrong length");
  return {std::move(inputs), vector_of(t.numbers("shift")), vector_of(t.numbers("factor"))};
}

}  // namespace repose::surrogate
