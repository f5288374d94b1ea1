// Changing a table in a file so that no other writer's change is lost.
#pragma once

#include <functional>

#include "repose/table/io.hpp"

namespace repose::table {

/// Reads the table, lets `change` alter it and writes it back together with the file's other tables
/// and attributes; readers see the old file or the new one. Meanwhile any other writer of the file,
/// in this process or another, is refused, and so is this one if another is at work. If `change`
/// throws, the file stays as it was.
/// Throws StorageError if the file cannot be read or written or has a writer, InputError if it
/// holds anything but tables of repose: writing it back would lose that.
void update_table(const Location& location, const std::function<void(Table&)>& change);

}  // namespace repose::table
