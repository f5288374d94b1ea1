// Writing a large table a block of rows at a time.
#pragma once

#include <cstddef>
#include <memory>

#include "repose/table/io.hpp"

namespace repose::table {

/// A table that is being written and of which only a piece is held: at most 64 MB, or 1024 rows if
/// they are larger, and as much again in HDF5. The file appears whole with finish(), until when the
/// old one stays; nobody else may write it meanwhile. Calls from several threads need a lock.
///
/// A table of fewer rows than a piece is stored as write_table() stores it, a larger one in chunks
/// that every HDF5 program reads.
class TableWriter {
 public:
  /// `header` says names, units, roles, ranges and attributes, and by its (empty) values the types
  /// of the columns; TableReader::header() is one. Throws as write_table() does, and InputError if
  /// `header` has rows.
  TableWriter(const Location& location, const Table& header);
  TableWriter(TableWriter&&) noexcept;
  TableWriter& operator=(TableWriter&&) noexcept;
  /// Without finish() nothing remains.
  ~TableWriter();

  /// Adds the rows of a table that has the header's columns, in any order; its roles, ranges and
  /// attributes are not looked at. Throws InputError for other columns, units, types or values that
  /// write_table() refuses (then none of these rows is written and others may follow), StorageError
  /// if they cannot be written (then none can).
  void append(const Table& block);
  /// Rows so far.
  std::size_t rows() const;
  /// Puts the file in its place; nothing can be appended any more. Throws StorageError.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace repose::table
