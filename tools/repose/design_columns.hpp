// A table as a design: which columns are factors, and their values in coded units.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/table/table.hpp"

namespace repose::cli {

/// A factors file: [parameters] and, if wanted, [fixed], [ties] and [constraints], as
/// read_parameter_space() takes them.
ParameterSpace read_factors(const std::string& file);

struct FactorOptions {
  std::vector<std::string> columns;  ///< names of the factors' columns
  std::string factors;               ///< factors file, for the ranges
};

/// Adds --columns and --factors.
void add_factor_options(CLI::App& command, FactorOptions& options);

/// One factor of a design: -1, 0 and 1 are `lower`, `middle` and `upper`.
struct DesignFactor {
  std::string name;
  double lower = 0.0, middle = 0.0, upper = 0.0;
  Scale scale = Scale::linear;
  std::vector<std::string> categories =
      {};  ///< of a factor of names, whose values are their places
  Parameter parameter() const;
};

struct CodedDesign {
  std::vector<DesignFactor> factors;
  Matrix coded;  ///< rows of the table x factors
  std::vector<std::string> names() const;
  /// Back to natural units; levels -1, 0 and 1 exactly as in `factors`.
  double natural(std::size_t factor, double coded) const;
};

/// Factors are the columns asked for, else those of the factors file, else those with the role
/// factor, else all columns of numbers but `others` and the customary names of runs, pairs and
/// repetitions, if they have few levels. A factor varies in the range of the factors file, else in
/// that of the column, else between its smallest and largest value: on a logarithmic scale if there
/// is one level between them and it is nearer to their geometric mean than to the arithmetic one.
/// Throws InputError for a column that is constant, has missing values or leaves its range.
CodedDesign coded_design(const table::Table& table, const FactorOptions& options,
                         const std::vector<std::string>& others = {});

/// The scale on which three levels are more nearly equally spaced; linear for other numbers of
/// levels.
Scale scale_of_levels(std::vector<double> values);

/// The values of a column of texts or integers as text, for grouping rows. Throws InputError for a
/// column of other numbers.
std::vector<std::string> row_labels(const table::Table& table, const std::string& column);

/// The columns named, else those with the role response. Throws InputError if there are none.
std::vector<std::string> response_columns(const table::Table& table,
                                          const std::vector<std::string>& named);

}  // namespace repose::cli
