// A table that grows by rows and is written in closed chunks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "repose/table/table.hpp"

namespace repose::scene {

enum class ColumnType { real, integer };

struct ColumnHead {
  std::string name;
  std::string unit = "1";
  ColumnType type = ColumnType::real;
};

/// Rows wait in memory and go to FOLDER/NAME_000001.h5 ... when there are many or flush() asks.
class RowTable {
 public:
  RowTable(std::filesystem::path folder, std::string name, std::vector<ColumnHead> heads);

  const std::string& name() const { return name_; }
  /// One value a column, whole numbers for integer ones. Throws StorageError.
  void add(const std::vector<double>& row);
  /// Writes what waits as a chunk. Throws StorageError.
  void flush();
  int chunks() const { return chunks_; }
  /// Goes on after the first `chunks` files of an earlier run; removes those that follow. Throws
  /// StorageError if one is missing.
  void go_on_after(int chunks);
  bool is_empty() const { return chunks_ == 0 && waiting_.front().empty(); }
  /// All rows so far as one table; reads the chunks. Throws StorageError.
  table::Table whole();

 private:
  std::filesystem::path chunk_file(int number) const;

  std::filesystem::path folder_;
  std::string name_;
  std::vector<ColumnHead> heads_;
  std::vector<std::vector<double>> waiting_;  // by column
  int chunks_ = 0;
};

}  // namespace repose::scene
