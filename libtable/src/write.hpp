// Writing by whoever holds the WriterLock of the file.
#pragma once

#include "repose/table/io.hpp"

namespace repose::table {

bool is_csv(const std::filesystem::path& file);
void write_tables_locked(const std::filesystem::path& file,
                         const std::vector<std::pair<std::string, Table>>& groups,
                         const Attributes& file_attributes);
void write_csv_locked(const std::filesystem::path& file, const Table& table);

}  // namespace repose::table
