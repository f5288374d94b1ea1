#include "repose/table/update.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "layout.hpp"
#include "repose/base/error.hpp"
#include "write.hpp"
#include "writer_lock.hpp"

namespace repose::table {
namespace {

struct Contents {
  std::vector<std::pair<std::string, Table>> tables;
  Attributes attributes;  ///< of the root, unless it is a table
};

bool is_ours(const hdf5::Object& group) {
  const auto format = hdf5::read_attribute(group, kFormatAttribute);
  return format && *format == Attribute(std::string(kTableFormat));
}

bool holds_only_groups(const hdf5::Object& group) {
  const std::vector<hdf5::Child> children = hdf5::children(group);
  return std::all_of(children.begin(), children.end(),
                     [](const hdf5::Child& child) { return child.kind == hdf5::ChildKind::group; });
}

Contents contents_of(const std::filesystem::path& path) {
  const hdf5::Session session;
  const hdf5::Object file = hdf5::open_file(path);
  Contents contents;
  for (const std::string& group_path : hdf5::all_groups(file)) {
    const hdf5::Object group = hdf5::open_group(file, group_path);
    if (is_ours(group)) {
      contents.tables.emplace_back(group_path, read_all(find_table(file, group_path)));
      continue;
    }
    Attributes attributes = hdf5::read_attributes(group);
    if (!holds_only_groups(group) || attributes.contains(kFormatAttribute) ||
        (group_path != "/" && !attributes.empty()))
      throw InputError(
          fmt::format("{} cannot be changed in place: {} is no table of repose and would be lost; "
                      "import the table into a file of its own",
                      path.string(), group.where));
    if (group_path == "/") contents.attributes = std::move(attributes);
  }
  return contents;
}

Table& chosen(Contents& contents, const Location& location) {
  for (auto& [path, table] : contents.tables)
    if (path == location.group || (location.group.empty() && contents.tables.size() == 1))
      return table;
  throw InputError(
      location.group.empty()
          ? fmt::format("{} holds {} tables; choose one with {}:/NAME", location.file.string(),
                        contents.tables.size(), location.file.string())
          : fmt::format("{} holds no table {}", location.file.string(), location.group));
}

}  // namespace

void update_table(const Location& location, const std::function<void(Table&)>& change) {
  const WriterLock lock(location.file);
  if (is_csv(location.file)) {
    Table table = read_csv(location.file, Missing::allow);
    change(table);
    return write_csv_locked(location.file, table);
  }
  Contents contents = contents_of(location.file);
  change(chosen(contents, location));
  write_tables_locked(location.file, contents.tables, contents.attributes);
}

}  // namespace repose::table
