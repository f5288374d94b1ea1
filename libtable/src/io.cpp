#include "repose/table/io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <new>

#include "checks.hpp"
#include "layout.hpp"
#include "repose/base/error.hpp"
#include "write.hpp"

namespace repose::table {
namespace {

Table read_hdf5_table(const Location& location) try {
  const hdf5::Session session;
  const hdf5::Object file = hdf5::open_file(location.file);
  const Layout layout = find_table(file, location.group);
  return read_all(layout);
} catch (const std::bad_alloc&) {
  throw StorageError(
      fmt::format("cannot read {}: its values do not fit into memory", location_text(location)));
}

}  // namespace

bool is_csv(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".csv";
}

Location parse_location(std::string_view text) {
  const std::size_t colon = text.rfind(":/");
  Location location{std::string(text.substr(0, colon)),
                    colon == std::string_view::npos ? "" : std::string(text.substr(colon + 1))};
  if (location.file.empty())
    throw InputError(
        fmt::format("\"{}\" names no file; write FILE.h5, FILE.h5:/group or FILE.csv", text));
  if (is_csv(location.file) && !location.group.empty())
    throw InputError(fmt::format("\"{}\" asks for a group of a CSV file, which has none", text));
  if (!location.group.empty()) check_group(location.group, location.file);
  return location;
}

std::string location_text(const Location& location) {
  return location.group.empty() ? location.file.string()
                                : fmt::format("{}:{}", location.file.string(), location.group);
}

Table read_table(const Location& location, Missing missing) {
  if (is_csv(location.file)) return read_csv(location.file, missing);
  Table table = read_hdf5_table(location);
  const std::string where = location_text(location);
  refuse_values(table, where, missing);
  return table;
}

std::vector<std::string> list_tables(const std::filesystem::path& file) {
  if (is_csv(file)) return {};
  const hdf5::Session session;
  return table_paths(hdf5::open_file(file));
}

Attributes read_attributes(const Location& location) {
  const hdf5::Session session;
  const hdf5::Object file = hdf5::open_file(location.file);
  return hdf5::read_attributes(
      hdf5::open_group(file, location.group.empty() ? "/" : location.group));
}

}  // namespace repose::table
