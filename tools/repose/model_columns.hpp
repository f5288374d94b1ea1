// Columns of tables as inputs of surrogates.
#pragma once

#include <string>
#include <vector>

#include "repose/surrogate/model_file.hpp"
#include "repose/table/table.hpp"

namespace repose::cli {

/// What the columns of a table say of themselves: declared ranges and log scales, or the range of
/// the data; columns of text are categories, their levels in alphabetical order.
std::vector<surrogate::Input> inputs_from_columns(const table::Table& table,
                                                  const std::vector<std::string>& names,
                                                  const std::vector<std::string>& log_names,
                                                  surrogate::Coding coding);

/// rows x d values of the inputs, levels as their numbers. Throws InputError on a level the model
/// does not know. `numbers`: of rows that are selected ones of another table, from 0, for messages.
Matrix input_matrix(const table::Table& table, const std::vector<std::string>& names,
                    const std::vector<surrogate::Input>& inputs,
                    const std::vector<std::size_t>& numbers = {});

/// A column's values, numbers as text, "" where one is missing.
std::vector<std::string> known_labels_of(const table::Table& table, const std::string& name);
/// The same; throws InputError where one is missing.
std::vector<std::string> labels_of(const table::Table& table, const std::string& name);

}  // namespace repose::cli
