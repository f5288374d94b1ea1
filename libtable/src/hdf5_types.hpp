// What datasets and attributes have in common: runs of elements of one type.
#pragma once

#include <functional>

#include "hdf5.hpp"

namespace repose::table::hdf5 {

/// `count` elements of `type` in a file and how to get them, converted to a type in memory.
struct Source {
  hid_t type;
  std::size_t count;
  const std::string& where;
  std::function<void(hid_t memory_type, void* data)> fetch;
};

/// Nothing if the type is neither number nor text.
std::optional<Values> read_known(const Source& source);

/// Variable-length UTF-8.
Handle text_type(const std::string& where);
std::vector<const char*> pointers_to(const std::vector<std::string>& texts);

}  // namespace repose::table::hdf5
