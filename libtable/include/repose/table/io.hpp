// Tables on disk: groups of 1-D datasets in HDF5 files, and CSV.
//
// An HDF5 table is a group; each column is a 1-D dataset with the attributes `unit`, `role` and,
// for a factor's range, `lower`, `upper` and `scale`. The group carries `repose_format` ("table
// 1"), `repose_version`, `column_order` and the table's own attributes. Text is variable-length
// UTF-8. Every write is atomic: a temporary file beside the target, flushed, renamed. All functions
// may be called from several threads; they take turns.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "repose/table/table.hpp"

namespace repose::table {

/// A table in a file.
struct Location {
  std::filesystem::path file;
  /// Absolute path of the HDF5 group, or when reading dataset, that holds the table, e.g.
  /// "/design". Empty: the only table of the file when reading, "/table" when writing. Always
  /// empty for CSV.
  std::string group;
};

/// "FILE.h5:/path", "FILE.h5" or "FILE.csv". Throws InputError.
Location parse_location(std::string_view text);
/// The text that parse_location() reads.
std::string location_text(const Location& location);

/// Whether reading accepts missing values: NaN, an empty CSV cell. Infinite values are never
/// accepted.
enum class Missing { refuse, allow };

/// Reads a table; a file named *.csv is CSV, any other HDF5, which repose need not have written:
/// - a group: its 1-D datasets are the columns, in the order of `column_order` if present, else of
///   creation if recorded, else of their names; a 2-D dataset x beside them is the columns x_1,
///   x_2,
///   ...; scalars and groups inside it are ignored;
/// - a compound dataset (PyTables, pandas with format="table"): its members are the columns, an
///   array member x is x_1, x_2, ... or what pandas called them; pandas' index has the role id;
/// - a 2-D dataset of numbers: named by its attribute `column_names`, `columns` or `names`, else
/// c1,
///   c2, ...;
/// - MATLAB v7.3: an array of numbers, as above but transposed as MATLAB stores it, and a struct of
///   arrays, as a group; objects (`table`, `string`) only MATLAB can read.
/// A group that holds nothing but one such dataset stands for it.
/// Throws StorageError if the file or the path cannot be read or is damaged, InputError if columns
/// differ in length, have a type that is neither number nor text or hold values that are not
/// allowed, and if no path is given but the file has several tables.
Table read_table(const Location& location, Missing missing = Missing::refuse);

/// Writes one table, replacing the whole file; *.csv is CSV, any other name HDF5. Throws
/// StorageError if it cannot be written or another process or thread is writing it, InputError for
/// an infinite value, a name with "/" (HDF5) or a NUL in a text; the old file then stays as it was.
void write_table(const Location& location, const Table& table);

/// Writes several tables, (group, table) each, into one HDF5 file with attributes of its root
/// group.
void write_tables(const std::filesystem::path& file,
                  const std::vector<std::pair<std::string, Table>>& groups,
                  const Attributes& file_attributes = {});

/// The groups and datasets of an HDF5 file that read_table() takes for tables; none of CSV.
std::vector<std::string> list_tables(const std::filesystem::path& file);

/// Attributes of any HDF5 group, "/" included (an empty group means "/"), all that have a type of
/// `Attribute`; others are ignored.
Attributes read_attributes(const Location& location);

/// CSV as in RFC 4180, UTF-8, first line `name` or `name [unit]` for each column. Reading accepts a
/// byte order mark and CRLF and finds each column's type: integers, doubles or text. A quoted cell
/// is text (unless every cell of the file is quoted), an unquoted empty one or `nan` is missing.
/// Roles, ranges and attributes do not survive CSV; names, units, types and all bits of the values
/// do, unless the table holds only texts that must be quoted, like 1: they come back as numbers.
Table read_csv(const std::filesystem::path& file, Missing missing = Missing::refuse);
/// As read_csv() from text; `name` stands for the file in messages.
Table parse_csv(std::string_view text, const std::string& name, Missing missing = Missing::refuse);
void write_csv(const std::filesystem::path& file, const Table& table);
/// The text that write_csv() writes.
std::string csv_text(const Table& table);

}  // namespace repose::table
