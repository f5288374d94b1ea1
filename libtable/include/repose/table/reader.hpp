// Reading a large table column by column, a block of rows at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>

#include "repose/table/io.hpp"

namespace repose::table {

/// An open table of which only what is asked for is read: a block of one column and HDF5's chunk
/// cache, at most 1 MB a dataset, are held. A file that is replaced meanwhile is read as it was.
/// CSV has no columns to go to: its whole table is held. Calls from several threads take turns.
class TableReader {
 public:
  /// Reads names, attributes and lengths; finds tables and throws as read_table() does.
  explicit TableReader(const Location& location, Missing missing = Missing::refuse);
  TableReader(TableReader&&) noexcept;
  TableReader& operator=(TableReader&&) noexcept;
  ~TableReader();

  /// Columns with name, unit, role, range and type (that of their empty values), and the
  /// attributes.
  const Table& header() const;
  std::size_t rows() const;

  /// Rows [first, first + count) of a column, checked as read_table() does. Throws InputError for a
  /// column or rows that do not exist.
  Values values(std::string_view column, std::size_t first, std::size_t count) const;

  /// Passes a column in blocks of about a hundred thousand rows; `take` gets the first row of each.
  void for_each_block(std::string_view column,
                      const std::function<void(std::size_t first, Values values)>& take) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace repose::table
