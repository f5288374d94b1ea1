// Where the tables of an HDF5 file are and where their columns lie, whoever wrote it.
//
// Five layouts: a group of 1-D datasets (repose, h5py), a compound dataset (PyTables, pandas), a
// 2-D dataset of numbers, an array of numbers and a struct of arrays of a MATLAB v7.3 file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hdf5.hpp"
#include "repose/table/table.hpp"

namespace repose::table {

inline constexpr const char* kFormatAttribute = "repose_format";
inline constexpr const char* kOrderAttribute = "column_order";
inline constexpr const char* kTableFormat = "table 1";

struct ColumnPlace {
  std::shared_ptr<const hdf5::Object> dataset;  ///< shared by columns that lie in one dataset
  hdf5::Part part;
};

/// A table that has been found but not read.
struct Layout {
  Table header;                     ///< columns without values, attributes
  std::vector<ColumnPlace> places;  ///< of each column
  hsize_t rows = 0;
  std::string where;
};

/// Paths of all tables of the file.
std::vector<std::string> table_paths(const hdf5::Object& file);

/// The table at a path, or the only one of the file if `path` is empty. Throws StorageError if
/// there is nothing at the path, InputError if it is no table or there are several.
Layout find_table(const hdf5::Object& file, const std::string& path);

/// Rows of one column, not yet checked.
Values read_rows(const Layout& layout, std::size_t column, const hdf5::RowRange& rows);
/// All rows of all columns; a dataset with several columns is passed once, in blocks.
Table read_all(const Layout& layout);

}  // namespace repose::table
