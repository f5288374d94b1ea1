// Tables into HDF5 files: what may be stored, and how.
#include "write.hpp"

#include <fmt/format.h>

#include <set>
#include <system_error>

#include "checks.hpp"
#include "layout.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "writer_lock.hpp"

namespace repose::table {
namespace {

constexpr const char* kVersionAttribute = "repose_version";
constexpr const char* kDefaultGroup = "/table";

void check_attributes(const Attributes& attributes, const std::string& where) {
  for (const auto& [name, value] : attributes) {
    if (name.empty()) throw InputError(fmt::format("an attribute of {} has no name", where));
    refuse_nul(name, where);
    if (const auto* text = std::get_if<std::string>(&value)) refuse_nul(*text, where);
    if (const auto* texts = std::get_if<std::vector<std::string>>(&value))
      for (const std::string& text : *texts) refuse_nul(text, where);
  }
}

void write_attributes(const hdf5::Object& object, const Attributes& attributes) {
  for (const auto& [name, value] : attributes) hdf5::write_attribute(object, name, value);
}

}  // namespace

TemporaryFile::TemporaryFile(const std::filesystem::path& target)
    : path_(temporary_beside(target)) {}
TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

std::string chosen_group(const Location& location) {
  const std::string group = location.group.empty() ? kDefaultGroup : location.group;
  check_group(group, location.file);
  return group;
}

void check_storable(const Table& table, const std::string& where) {
  refuse_values(table, where, Missing::allow);
  check_attributes(table.attributes, where);
  for (const char* name : {kFormatAttribute, kOrderAttribute})
    if (table.attributes.contains(name))
      throw InputError(
          fmt::format("{}: the attribute \"{}\" is written by repose itself; choose another name",
                      where, name));
  for (const Column& column : table.columns()) {
    if (column.name == "." || column.name.find('/') != std::string::npos)
      throw InputError(
          fmt::format("column \"{}\" of {} cannot be stored in HDF5: rename it to "
                      "something without \"/\"",
                      column.name, where));
    for (const std::string& text : {column.name, column.unit}) refuse_nul(text, where);
    refuse_nul(column.values, where);
  }
}

void check_group(const std::string& group, const std::filesystem::path& file) {
  if (group.starts_with('/') && (group == "/" || !group.ends_with('/')) &&
      group.find("//") == std::string::npos)
    return;
  throw InputError(fmt::format("\"{}\" cannot name a group of {}; it must be like \"/design\"",
                               group, file.string()));
}

void write_description(const hdf5::Object& dataset, const Column& column) {
  hdf5::write_attribute(dataset, "unit", column.unit);
  if (column.role != Role::none) hdf5::write_attribute(dataset, "role", role_name(column.role));
  if (!column.range) return;
  hdf5::write_attribute(dataset, "lower", column.range->lower);
  hdf5::write_attribute(dataset, "upper", column.range->upper);
  hdf5::write_attribute(dataset, "scale",
                        std::string(column.range->scale == Scale::log ? "log" : "linear"));
}

void write_description(const hdf5::Object& group, const Table& table) {
  Attributes attributes = table.attributes;
  attributes.try_emplace(kVersionAttribute, std::string(version()));
  attributes[kFormatAttribute] = std::string(kTableFormat);
  attributes[kOrderAttribute] = table.names();
  write_attributes(group, attributes);
}

void write_group(const hdf5::Object& file, const std::string& path, const Table& table) {
  const hdf5::Object group = hdf5::create_group(file, path);
  for (const Column& column : table.columns())
    write_description(hdf5::write_values(group, column.name, column.values), column);
  write_description(group, table);
}

void write_table(const Location& location, const Table& table) {
  if (is_csv(location.file)) return write_csv(location.file, table);
  write_tables(location.file, {{chosen_group(location), table}});
}

void write_tables(const std::filesystem::path& file,
                  const std::vector<std::pair<std::string, Table>>& groups,
                  const Attributes& file_attributes) {
  const WriterLock lock(file);
  write_tables_locked(file, groups, file_attributes);
}

void write_tables_locked(const std::filesystem::path& file,
                         const std::vector<std::pair<std::string, Table>>& groups,
                         const Attributes& file_attributes) {
  std::set<std::string> paths;
  check_attributes(file_attributes, file.string());
  for (const auto& [path, table] : groups) {
    check_group(path, file);
    if (path == "/" && !file_attributes.empty())
      throw InputError(fmt::format(
          "{}: its attributes belong to the table in \"/\"; put them there", file.string()));
    if (!paths.insert(path).second)
      throw InputError(
          fmt::format("two tables of {} are to be written to the group {}", file.string(), path));
    check_storable(table, location_text({file, path}));
  }
  const TemporaryFile temporary(file);
  {
    const hdf5::Session session;
    hdf5::Object output = hdf5::create_file(temporary.path(), file.string());
    for (const auto& [path, table] : groups) write_group(output, path, table);
    write_attributes(hdf5::open_group(output, "/"), file_attributes);
    hdf5::finish_file(std::move(output));
  }
  commit_file(temporary.path(), file);
}

}  // namespace repose::table
