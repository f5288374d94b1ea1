#include "repose/table/io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <system_error>

#include "checks.hpp"
#include "hdf5.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::table {
namespace {

constexpr const char* kFormatAttribute = "repose_format";
constexpr const char* kOrderAttribute = "column_order";
constexpr const char* kVersionAttribute = "repose_version";
constexpr const char* kTableFormat = "table 1";
constexpr const char* kDefaultGroup = "/table";

bool is_csv(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".csv";
}

/// Removes a file that was not committed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& target) : path_(temporary_beside(target)) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::optional<std::string> text_attribute(const hdf5::Object& object, const char* name) {
  const std::optional<Attribute> value = hdf5::read_attribute(object, name);
  if (!value) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(&*value)) return *text;
  throw InputError(fmt::format("attribute \"{}\" of {} is not a text", name, object.where));
}

std::optional<double> number_attribute(const hdf5::Object& object, const char* name) {
  const std::optional<Attribute> value = hdf5::read_attribute(object, name);
  if (!value) return std::nullopt;
  if (const auto* number = std::get_if<double>(&*value)) return *number;
  if (const auto* integer = std::get_if<std::int64_t>(&*value))
    return static_cast<double>(*integer);
  throw InputError(fmt::format("attribute \"{}\" of {} is not a number", name, object.where));
}

// ---- reading

std::optional<FactorRange> read_range(const hdf5::Object& dataset) {
  const std::optional<double> lower = number_attribute(dataset, "lower");
  const std::optional<double> upper = number_attribute(dataset, "upper");
  if (!lower || !upper) return std::nullopt;
  const std::string scale = text_attribute(dataset, "scale").value_or("linear");
  if (scale != "linear" && scale != "log")
    throw InputError(fmt::format("attribute \"scale\" of {} is \"{}\"; allowed are linear and log",
                                 dataset.where, scale));
  return FactorRange{*lower, *upper, scale == "log" ? Scale::log : Scale::linear};
}

Role read_role(const hdf5::Object& dataset) try {
  const std::optional<std::string> role = text_attribute(dataset, "role");
  return role ? role_from_name(*role) : Role::none;
} catch (const InputError& error) {
  throw InputError(fmt::format("{}: {}", dataset.where, error.what()));
}

Column read_column(const hdf5::Object& group, const std::string& name) {
  const hdf5::Object dataset = hdf5::open_dataset(group, name);
  const auto extents = hdf5::extents(dataset);
  if (!extents || extents->size() != 1)
    throw InputError(fmt::format("{} has {} dimensions; a column of a table has one", dataset.where,
                                 extents ? extents->size() : 0));
  return {.name = name,
          .unit = text_attribute(dataset, "unit").value_or("1"),
          .role = read_role(dataset),
          .range = read_range(dataset),
          .values = hdf5::read_values(dataset)};
}

/// Datasets that are columns if nothing says which: all but scalars.
std::vector<std::string> column_candidates(const hdf5::Object& group) {
  std::vector<std::string> names;
  for (const hdf5::Child& child : hdf5::children(group)) {
    if (child.kind != hdf5::ChildKind::dataset) continue;
    const auto extents = hdf5::extents(hdf5::open_dataset(group, child.name));
    if (extents && !extents->empty()) names.push_back(child.name);
  }
  return names;
}

std::vector<std::string> column_order(const hdf5::Object& group) {
  const std::optional<Attribute> order = hdf5::read_attribute(group, kOrderAttribute);
  if (!order) return column_candidates(group);
  if (const auto* names = std::get_if<std::vector<std::string>>(&*order)) return *names;
  // An array of no texts may come back as an array of numbers from other writers.
  if (const auto* numbers = std::get_if<std::vector<double>>(&*order); numbers && numbers->empty())
    return {};
  throw InputError(
      fmt::format("attribute \"{}\" of {} is not an array of texts", kOrderAttribute, group.where));
}

bool is_table(const hdf5::Object& group) {
  const std::optional<std::string> format = text_attribute(group, kFormatAttribute);
  if (format) return format->starts_with("table ");
  return !column_candidates(group).empty();
}

std::vector<std::string> tables_of(const hdf5::Object& file) {
  std::vector<std::string> result;
  for (const std::string& path : hdf5::all_groups(file))
    if (is_table(hdf5::open_group(file, path))) result.push_back(path);
  return result;
}

std::string only_table_of(const hdf5::Object& file) {
  const std::vector<std::string> tables = tables_of(file);
  if (tables.size() == 1) return tables.front();
  if (tables.empty())
    throw InputError(fmt::format("{} holds no table: no group with 1-D datasets", file.where));
  throw InputError(fmt::format("{} holds {} tables, {}; choose one, e.g. {}:{}", file.where,
                               tables.size(), listed(tables), file.where, tables.front()));
}

void check_format(const hdf5::Object& group) {
  const std::string format = text_attribute(group, kFormatAttribute).value_or(kTableFormat);
  if (format == kTableFormat) return;
  throw InputError(fmt::format(
      "{} has the format \"{}\"; this version of repose reads \"{}\" as a table{}", group.where,
      format, kTableFormat, format.starts_with("table ") ? "; use a newer one" : ""));
}

Table read_hdf5_table(const Location& location) {
  const hdf5::Session session;
  const hdf5::Object file = hdf5::open_file(location.file);
  const std::string path = location.group.empty() ? only_table_of(file) : location.group;
  const hdf5::Object group = hdf5::open_group(file, path);
  check_format(group);
  const std::vector<std::string> names = column_order(group);
  if (names.empty() && !hdf5::read_attribute(group, kFormatAttribute))
    throw InputError(fmt::format("{} is not a table: it holds no 1-D datasets", group.where));
  Table table;
  try {
    for (const std::string& name : names) table.add(read_column(group, name));
  } catch (const InputError& error) {
    throw InputError(fmt::format("cannot read {} as a table: {}", group.where, error.what()));
  }
  table.attributes = hdf5::read_attributes(group);
  table.attributes.erase(kFormatAttribute);
  table.attributes.erase(kOrderAttribute);
  return table;
}

// ---- writing

void check_attributes(const Attributes& attributes, const std::string& where) {
  for (const auto& [name, value] : attributes) {
    if (name.empty()) throw InputError(fmt::format("an attribute of {} has no name", where));
    refuse_nul(name, where);
    if (const auto* text = std::get_if<std::string>(&value)) refuse_nul(*text, where);
    if (const auto* texts = std::get_if<std::vector<std::string>>(&value))
      for (const std::string& text : *texts) refuse_nul(text, where);
  }
}

void check_storable(const Table& table, const std::string& where) {
  refuse_infinite(table, where);
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
    if (const auto* texts = std::get_if<std::vector<std::string>>(&column.values))
      for (const std::string& text : *texts) refuse_nul(text, where);
  }
}

void check_group(const std::string& group, const std::filesystem::path& file) {
  if (group.starts_with('/') && (group == "/" || !group.ends_with('/')) &&
      group.find("//") == std::string::npos)
    return;
  throw InputError(fmt::format("\"{}\" cannot name a group of {}; it must be like \"/design\"",
                               group, file.string()));
}

void write_column(const hdf5::Object& group, const Column& column) {
  const hdf5::Object dataset = hdf5::write_values(group, column.name, column.values);
  hdf5::write_attribute(dataset, "unit", column.unit);
  if (column.role != Role::none) hdf5::write_attribute(dataset, "role", role_name(column.role));
  if (!column.range) return;
  hdf5::write_attribute(dataset, "lower", column.range->lower);
  hdf5::write_attribute(dataset, "upper", column.range->upper);
  hdf5::write_attribute(dataset, "scale",
                        std::string(column.range->scale == Scale::log ? "log" : "linear"));
}

void write_attributes(const hdf5::Object& object, const Attributes& attributes) {
  for (const auto& [name, value] : attributes) hdf5::write_attribute(object, name, value);
}

void write_group(const hdf5::Object& file, const std::string& path, const Table& table) {
  const hdf5::Object group = hdf5::create_group(file, path);
  for (const Column& column : table.columns()) write_column(group, column);
  Attributes attributes = table.attributes;
  attributes.try_emplace(kVersionAttribute, std::string(version()));
  attributes[kFormatAttribute] = std::string(kTableFormat);
  attributes[kOrderAttribute] = table.names();
  write_attributes(group, attributes);
}

}  // namespace

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
  refuse_infinite(table, where);
  if (missing == Missing::refuse) refuse_missing(table, where);
  return table;
}

void write_table(const Location& location, const Table& table) {
  if (is_csv(location.file)) return write_csv(location.file, table);
  write_tables(location.file, {{location.group.empty() ? kDefaultGroup : location.group, table}});
}

void write_tables(const std::filesystem::path& file,
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

std::vector<std::string> list_tables(const std::filesystem::path& file) {
  const hdf5::Session session;
  return tables_of(hdf5::open_file(file));
}

Attributes read_attributes(const Location& location) {
  const hdf5::Session session;
  const hdf5::Object file = hdf5::open_file(location.file);
  return hdf5::read_attributes(
      hdf5::open_group(file, location.group.empty() ? "/" : location.group));
}

}  // namespace repose::table
