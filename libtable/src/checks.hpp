// Values that a table on disk must not hold; each check throws InputError naming file, column and
// row.
#pragma once

#include <string>
#include <string_view>

#include "repose/table/io.hpp"

namespace repose::table {

inline constexpr const char* kMissingReason =
    "has no value; fill it in, drop the row or allow missing values";

/// Throws "`where`: row `row` + 1 of column `column` `why`".
[[noreturn]] void refuse_cell(std::string_view column, std::size_t row, const std::string& where,
                              const char* why);

/// Infinite values, and NaN unless missing values are allowed; `first` is the row of the first
/// value. A text in memory is never missing.
void refuse_values(const Values& values, std::string_view column, std::size_t first,
                   const std::string& where, Missing missing);
void refuse_values(const Table& table, const std::string& where, Missing missing);
/// C strings, and so HDF5's, end at NUL.
void refuse_nul(const std::string& text, const std::string& where);
void refuse_nul(const Values& values, const std::string& where);

}  // namespace repose::table
