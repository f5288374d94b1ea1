// Rows of a table as data that any model is fitted to.
#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "repose/surrogate/training_set.hpp"
#include "repose/table/table.hpp"

namespace repose::cli {

/// What to predict, and from what.
struct TrainingColumns {
  std::string table;
  std::string response;
  std::vector<std::string> inputs;  ///< empty: the factors
  std::vector<std::string> log_inputs;
  std::string coding = "exchangeable";
  std::string group;      ///< column, or empty
  std::string replicate;  ///< column, or empty
  std::string noise;      ///< column of variances, which is no input by itself, or empty
};

/// TABLE, --response, --input, --log and --coding.
void add_training_columns(CLI::App* command, TrainingColumns* columns);
/// --replicate.
void add_replicate_column(CLI::App* command, TrainingColumns* columns);

struct TrainingTable {
  table::Table rows;  ///< those that are used, with all columns
  surrogate::TrainingSet data;
  std::vector<std::string> inputs;       ///< names
  std::vector<bool> undeclared;          ///< inputs whose range is that of the data
  std::vector<std::string> group_names;  ///< in order of the groups' numbers
};

/// The rows in which the response is not missing. Without --input the columns with the role
/// factor, or else all numbers but the response and what describes rows.
TrainingTable read_training_table(const TrainingColumns& columns);

}  // namespace repose::cli
