// Tables made from tables: selection, join, append, groups, missing values. Inputs stay as they
// are.
//
// A column that is not there throws InputError with the closest name, as Table's own functions do.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "repose/table/table.hpp"

namespace repose::table {

/// These columns in this order, with the attributes. Throws InputError for a name given twice.
Table selected_columns(const Table& table, const std::vector<std::string>& names);

/// Rows, from 0, of which `keep` is true; for Table::selected_rows().
std::vector<std::size_t> rows_where(const Table& table,
                                    const std::function<bool(std::size_t row)>& keep);
/// Rows in which none of the columns is missing: NaN, or an empty text.
std::vector<std::size_t> complete_rows(const Table& table, const std::vector<std::string>& names);

/// Rows with equal values in the key columns.
struct Group {
  std::vector<std::size_t> rows;  ///< in order; rows.front() stands for the keys
};
/// In order of first appearance. Throws InputError for a missing number among the keys.
std::vector<Group> grouped(const Table& table, const std::vector<std::string>& keys);

/// One row for each group: its keys, `rows` (how many), and for each response its mean under its
/// own name and its sample variance NAME_variance in the unit squared, role variance. Missing
/// values are left out; a mean of none and a variance of fewer than two are missing. Computed in
/// two passes.
Table group_means(const Table& table, const std::vector<std::string>& keys,
                  const std::vector<std::string>& responses);

/// What becomes of a left row that has no partner.
enum class Join {
  inner,  ///< left out
  left    ///< kept, the right columns missing: NaN (integers become decimal numbers), ""
};
/// Every left row with every right row of equal keys, in the left order, then the right. Keys keep
/// the left columns, attributes are the left ones. Integers match equal decimal numbers. Throws
/// InputError for keys of different type or missing, and for a name that both tables use for
/// something else.
Table joined(const Table& left, const Table& right, const std::vector<std::string>& keys,
             Join kind = Join::inner);

/// What becomes of a column that only one of the tables has.
enum class Unmatched { refuse, missing };
/// The rows of `first`, then of `second`, with columns, roles, ranges and attributes of `first`
/// and, with Unmatched::missing, of `second` what `first` lacks. Integers and decimal numbers
/// together are decimal numbers. Throws InputError for columns of different unit or type.
Table appended(const Table& first, const Table& second, Unmatched unmatched = Unmatched::refuse);

/// Gives columns other roles. Throws InputError for a text as factor, response, variance or weight.
Table with_roles(const Table& table, const std::map<std::string, Role>& roles);

}  // namespace repose::table
