// Values that a table on disk must not hold; each check throws InputError naming file, column and
// row.
#pragma once

#include <string>
#include <string_view>

#include "repose/table/table.hpp"

namespace repose::table {

inline constexpr const char* kMissingReason =
    "has no value; fill it in, drop the row or allow missing values";

/// Throws "`where`: row `row` + 1 of column `column` `why`".
[[noreturn]] void refuse_cell(std::string_view column, std::size_t row, const std::string& where,
                              const char* why);

void refuse_infinite(const Table& table, const std::string& where);
/// NaN; a text in memory is never missing.
void refuse_missing(const Table& table, const std::string& where);
/// C strings, and so HDF5's, end at NUL.
void refuse_nul(const std::string& text, const std::string& where);

}  // namespace repose::table
