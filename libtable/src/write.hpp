// Writing by whoever holds the WriterLock of the file.
#pragma once

#include "hdf5.hpp"
#include "repose/table/io.hpp"

namespace repose::table {

/// A name beside a file that is to be replaced; what stands there is removed unless it was
/// committed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& target);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

bool is_csv(const std::filesystem::path& file);
/// The group of an HDF5 file to write to. Throws InputError as check_group() does.
std::string chosen_group(const Location& location);

/// Throws InputError naming what HDF5 cannot store: names, values and attributes.
void check_storable(const Table& table, const std::string& where);
/// Throws InputError unless `group` is an absolute path.
void check_group(const std::string& group, const std::filesystem::path& file);

/// Unit, role and range of a column.
void write_description(const hdf5::Object& dataset, const Column& column);
/// Attributes of a table and what marks its group as one.
void write_description(const hdf5::Object& group, const Table& table);
void write_group(const hdf5::Object& file, const std::string& path, const Table& table);
void write_tables_locked(const std::filesystem::path& file,
                         const std::vector<std::pair<std::string, Table>>& groups,
                         const Attributes& file_attributes);

/// The first line of CSV, and the others.
std::string csv_header(const Table& table);
std::string csv_rows(const Table& table);
/// Throws InputError: CSV cannot show that a table has no columns.
void refuse_no_columns(const Table& table, const std::filesystem::path& file);
void write_csv_locked(const std::filesystem::path& file, const Table& table);

}  // namespace repose::table
