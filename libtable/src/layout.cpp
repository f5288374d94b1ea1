#include "layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "foreign.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::table {
namespace {

using hdf5::Object;
using SharedDataset = std::shared_ptr<const Object>;

// ---- what the attributes of a column say

std::optional<std::string> text_attribute(const Object& object, const char* name) {
  const std::optional<Attribute> value = hdf5::read_attribute(object, name);
  if (!value) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(&*value)) return *text;
  throw InputError(fmt::format("attribute \"{}\" of {} is not a text", name, object.where));
}

std::optional<double> number_attribute(const Object& object, const char* name) {
  const std::optional<Attribute> value = hdf5::read_attribute(object, name);
  if (!value) return std::nullopt;
  if (const auto* number = std::get_if<double>(&*value)) return *number;
  if (const auto* integer = std::get_if<std::int64_t>(&*value))
    return static_cast<double>(*integer);
  throw InputError(fmt::format("attribute \"{}\" of {} is not a number", name, object.where));
}

std::optional<FactorRange> read_range(const Object& dataset) {
  const std::optional<double> lower = number_attribute(dataset, "lower");
  const std::optional<double> upper = number_attribute(dataset, "upper");
  if (!lower || !upper) return std::nullopt;
  const std::string scale = text_attribute(dataset, "scale").value_or("linear");
  if (scale != "linear" && scale != "log")
    throw InputError(fmt::format("attribute \"scale\" of {} is \"{}\"; allowed are linear and log",
                                 dataset.where, scale));
  return FactorRange{*lower, *upper, scale == "log" ? Scale::log : Scale::linear};
}

Role read_role(const Object& dataset) try {
  const std::optional<std::string> role = text_attribute(dataset, "role");
  return role ? role_from_name(*role) : Role::none;
} catch (const InputError& error) {
  throw InputError(fmt::format("{}: {}", dataset.where, error.what()));
}

// ---- what a dataset can be

enum class Shape { single, column, records, matrix, unusable };

bool is_complex(const std::vector<hdf5::Member>& members) {
  return members.size() == 2 && ((members[0].name == "r" && members[1].name == "i") ||
                                 (members[0].name == "real" && members[1].name == "imag"));
}

Shape shape_of(const Object& dataset) {
  const auto extents = hdf5::extents(dataset);
  if (!extents) return Shape::unusable;
  if (extents->empty()) return Shape::single;
  if (extents->size() > 2) return Shape::unusable;
  if (extents->size() == 1) {
    const std::vector<hdf5::Member> members = hdf5::members(dataset);
    return members.empty() || is_complex(members) ? Shape::column : Shape::records;
  }
  const std::optional<std::string> matlab = matlab_class(dataset);
  // MATLAB has no arrays of fewer dimensions; a text is a row of characters.
  const bool is_vector = (*extents)[0] == 1 || (*extents)[1] == 1;
  if (!matlab || !is_vector) return Shape::matrix;
  const bool is_text = matlab == "char" && (*extents)[1] == 1;
  return is_text || (*extents)[0] == (*extents)[1] ? Shape::single : Shape::column;
}

std::string dimensions_refused(const Object& dataset) {
  const auto extents = hdf5::extents(dataset);
  return fmt::format("{} has {} dimensions; a column of a table has one, an array of columns two",
                     dataset.where, extents ? extents->size() : 0);
}

// ---- columns of a layout

/// More are no table but an array lying on its side, or damage that would keep us busy for hours.
constexpr std::size_t kMostColumns = 10000;

void add(Layout& layout, Column header, hsize_t rows, ColumnPlace place) {
  if (!layout.places.empty() && rows != layout.rows)
    throw InputError(
        fmt::format("column \"{}\" has {} rows, but the table has {}; columns must be equally long",
                    header.name, rows, layout.rows));
  if (layout.places.size() == kMostColumns)
    throw InputError(fmt::format("it has more than {} columns; is it transposed? Rows come first",
                                 kMostColumns));
  layout.rows = rows;
  layout.header.add(std::move(header));
  layout.places.push_back(std::move(place));
}

void add_column(Layout& layout, const std::string& name, const SharedDataset& dataset) {
  refuse_matlab_objects(*dataset);
  const std::vector<hsize_t> extents = hdf5::extents(*dataset).value();
  const int axis = extents.size() == 2 && extents[0] == 1 ? 1 : 0;
  Column header{.name = name,
                .unit = text_attribute(*dataset, "unit").value_or("1"),
                .role = read_role(*dataset),
                .range = read_range(*dataset)};
  add(layout, std::move(header), extents[static_cast<std::size_t>(axis)],
      {dataset, {.row_axis = axis}});
}

void add_records(Layout& layout, const SharedDataset& dataset) {
  const hsize_t rows = hdf5::extents(*dataset).value().front();
  for (const hdf5::Member& member : hdf5::members(*dataset)) {
    std::vector<std::string> names = pandas_names(*dataset, member.name);
    if (names.size() != member.elements) names.clear();
    for (std::size_t k = 0; k < member.elements; ++k) {
      const std::string name = !names.empty()         ? names[k]
                               : member.elements == 1 ? member.name
                                                      : fmt::format("{}_{}", member.name, k + 1);
      const Role role = is_pandas_index(*dataset, member.name) ? Role::id : Role::none;
      add(layout, {.name = name, .role = role}, rows,
          {dataset, {.member = member.name, .element = k}});
    }
  }
}

constexpr std::array<const char*, 3> kNamesAttributes = {"column_names", "columns", "names"};

/// Names of `count` columns that the dataset carries; none if it carries none.
std::vector<std::string> names_beside(const Object& dataset, hsize_t count) {
  for (const char* attribute : kNamesAttributes) {
    const auto value = hdf5::read_attribute(dataset, attribute);
    if (!value) continue;
    const auto* texts = std::get_if<std::vector<std::string>>(&*value);
    if (texts == nullptr || texts->size() != count)
      throw InputError(fmt::format(
          "attribute \"{}\" of {} must be an array of {} texts, the names of its columns; "
          "correct it or remove it",
          attribute, dataset.where, count));
    return *texts;
  }
  return {};
}

/// The columns of an array; without names of their own they are `prefix`1, `prefix`2, ...
void add_matrix(Layout& layout, const std::string& prefix, const SharedDataset& dataset) {
  refuse_matlab_objects(*dataset);
  if (!hdf5::holds_numbers(*dataset))
    throw InputError(fmt::format(
        "{} has two dimensions and does not hold real numbers but texts, complex numbers or "
        "references (a MATLAB array of structs); store a 1-D dataset for each column",
        dataset->where));
  // MATLAB counts from the first dimension, HDF5 from the last: it stores its arrays transposed.
  const int row_axis = matlab_class(*dataset) ? 1 : 0;
  const std::vector<hsize_t> extents = hdf5::extents(*dataset).value();
  const hsize_t rows = extents[static_cast<std::size_t>(row_axis)];
  const hsize_t columns = extents[static_cast<std::size_t>(1 - row_axis)];
  const std::vector<std::string> names = names_beside(*dataset, columns);
  for (hsize_t j = 0; j < columns; ++j)
    add(layout, {.name = names.empty() ? fmt::format("{}{}", prefix, j + 1) : names[j]}, rows,
        {dataset, {.row_axis = row_axis, .column = j}});
}

// ---- groups

/// A dataset of a group that belongs to the group's own table.
bool is_part_of_group(const Object& group, const Object& dataset, Shape shape) {
  if (shape == Shape::column || shape == Shape::unusable) return true;
  // A variable of a MATLAB workspace stands for itself, a field of a struct does not.
  return shape == Shape::matrix && (!matlab_class(dataset) || matlab_class(group));
}

/// What a group holds that could be tables.
struct Contents {
  std::vector<std::string> own;       ///< datasets that are columns of the group's table
  std::vector<std::string> separate;  ///< datasets that are tables by themselves
};

Contents contents_of(const Object& group) {
  Contents contents;
  bool has_column = false;
  for (const hdf5::Child& child : hdf5::children(group)) {
    if (child.kind != hdf5::ChildKind::dataset) continue;
    const Object dataset = hdf5::open_dataset(group, child.name);
    const Shape shape = shape_of(dataset);
    if (shape == Shape::single || !hdf5::extents(dataset)) continue;
    // In a workspace anything may lie beside the data.
    if (matlab_class(dataset) && !matlab_class(group) && !holds_matlab_numbers(dataset)) continue;
    if (is_part_of_group(group, dataset, shape))
      contents.own.push_back(child.name);
    else
      contents.separate.push_back(child.name);
    has_column |= shape == Shape::column;
  }
  if (!has_column && !matlab_class(group)) {
    // Arrays without a column beside them are tables by themselves.
    contents.separate.insert(contents.separate.end(), contents.own.begin(), contents.own.end());
    contents.own.clear();
  }
  std::sort(contents.separate.begin(), contents.separate.end());
  return contents;
}

std::optional<std::vector<std::string>> column_order(const Object& group) {
  const std::optional<Attribute> order = hdf5::read_attribute(group, kOrderAttribute);
  if (!order) return std::nullopt;
  if (const auto* names = std::get_if<std::vector<std::string>>(&*order)) return *names;
  // An array of no texts may come back as an array of numbers from other writers.
  if (const auto* numbers = std::get_if<std::vector<double>>(&*order); numbers && numbers->empty())
    return std::vector<std::string>{};
  throw InputError(
      fmt::format("attribute \"{}\" of {} is not an array of texts", kOrderAttribute, group.where));
}

void check_format(const Object& group) {
  const std::string format = text_attribute(group, kFormatAttribute).value_or(kTableFormat);
  if (format == kTableFormat) return;
  throw InputError(fmt::format(
      "{} has the format \"{}\"; this version of repose reads \"{}\" as a table{}", group.where,
      format, kTableFormat, format.starts_with("table ") ? "; use a newer one" : ""));
}

void add_dataset(Layout& layout, const std::string& name, const SharedDataset& dataset,
                 const std::string& matrix_prefix) {
  switch (shape_of(*dataset)) {
    case Shape::records:
      return add_records(layout, dataset);
    case Shape::matrix:
      return add_matrix(layout, matrix_prefix, dataset);
    case Shape::column:
      return add_column(layout, name, dataset);
    case Shape::single:
    case Shape::unusable:
      throw InputError(dimensions_refused(*dataset));
  }
}

Attributes attributes_of(const Object& object, bool is_ours) {
  Attributes attributes = hdf5::read_attributes(object);
  attributes.erase(kFormatAttribute);
  attributes.erase(kOrderAttribute);
  if (!is_ours)
    std::erase_if(attributes, [](const auto& a) { return is_internal_attribute(a.first); });
  return attributes;
}

template <class Fill>
Layout filled(const Object& object, bool is_ours, Fill fill) {
  Layout layout;
  layout.where = object.where;
  try {
    fill(layout);
  } catch (const InputError& error) {
    throw InputError(fmt::format("cannot read {} as a table: {}", object.where, error.what()));
  }
  layout.header.attributes = attributes_of(object, is_ours);
  return layout;
}

std::string file_name(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

Layout layout_of_dataset(const Object& file, const std::string& path) {
  const auto dataset = std::make_shared<const Object>(hdf5::open_dataset(file, path));
  Layout layout = filled(
      *dataset, false, [&](Layout& result) { add_dataset(result, file_name(path), dataset, "c"); });
  // Of a single column, unit and range belong to the column; of PyTables, all is its own.
  if (shape_of(*dataset) != Shape::matrix) layout.header.attributes.clear();
  for (const char* name : kNamesAttributes) layout.header.attributes.erase(name);
  return layout;
}

Layout layout_of_group(const Object& file, const std::string& path) {
  const Object group = hdf5::open_group(file, path);
  check_format(group);
  if (const auto why = why_unreadable(group)) throw InputError(*why);
  const bool is_ours = text_attribute(group, kFormatAttribute).has_value();
  std::optional<std::vector<std::string>> names = column_order(group);
  if (!names) {
    Contents contents = contents_of(group);
    if (contents.own.empty() && contents.separate.size() == 1)
      return layout_of_dataset(file, (path == "/" ? "/" : path + "/") + contents.separate.front());
    if (contents.own.empty() && contents.separate.size() > 1)
      throw InputError(fmt::format("{} holds {} tables, {}; choose one, e.g. {}{}{}", group.where,
                                   contents.separate.size(), listed(contents.separate), group.where,
                                   group.where.ends_with('/') ? "" : "/",
                                   contents.separate.front()));
    names = std::move(contents.own);
  }
  if (names->empty() && !is_ours)
    throw InputError(fmt::format("{} is not a table: it holds no 1-D datasets", group.where));
  return filled(group, is_ours, [&](Layout& layout) {
    for (const std::string& name : *names) {
      const auto dataset = std::make_shared<const Object>(hdf5::open_dataset(group, name));
      add_dataset(layout, name, dataset, name + "_");
    }
  });
}

/// Says what a file of another program holds that is close to a table.
void refuse_unreadable(const Object& file) {
  for (const std::string& path : hdf5::all_groups(file))
    if (const auto why = why_unreadable(hdf5::open_group(file, path))) throw InputError(*why);
  const Object root = hdf5::open_group(file, "/");
  for (const hdf5::Child& child : hdf5::children(root))
    if (child.kind == hdf5::ChildKind::dataset)
      refuse_matlab_objects(hdf5::open_dataset(root, child.name));
}

std::string only_table_of(const Object& file) {
  const std::vector<std::string> tables = table_paths(file);
  if (tables.size() == 1) return tables.front();
  if (tables.empty()) refuse_unreadable(file);
  if (tables.empty())
    throw InputError(fmt::format(
        "{} holds no table: no group with 1-D datasets, no compound dataset, no 2-D array of "
        "numbers",
        file.where));
  throw InputError(fmt::format("{} holds {} tables, {}; choose one, e.g. {}:{}", file.where,
                               tables.size(), listed(tables), file.where, tables.front()));
}

/// Rows in which the datasets of a table with several columns are read: at least this many.
constexpr hsize_t kBlockRows = 16 * 1024;

hsize_t block_rows(const Layout& layout, const ColumnPlace& place, bool is_shared) {
  if (!is_shared) return layout.rows;
  const hsize_t chunk = std::max<hsize_t>(1, hdf5::chunk_rows(*place.dataset, place.part));
  return chunk >= kBlockRows ? chunk : kBlockRows / chunk * chunk;
}

void append(Values& to, Values&& from) {
  std::visit(
      [&](auto& values) {
        auto& more = std::get<std::decay_t<decltype(values)>>(from);
        values.insert(values.end(), std::make_move_iterator(more.begin()),
                      std::make_move_iterator(more.end()));
      },
      to);
}

}  // namespace

std::vector<std::string> table_paths(const Object& file) {
  std::vector<std::string> result;
  for (const std::string& path : hdf5::all_groups(file)) {
    if (is_internal_path(path)) continue;
    const Object group = hdf5::open_group(file, path);
    if (why_unreadable(group)) continue;
    const std::optional<std::string> format = text_attribute(group, kFormatAttribute);
    const Contents contents = format ? Contents{} : contents_of(group);
    if (format ? format->starts_with("table ") : !contents.own.empty()) result.push_back(path);
    for (const std::string& name : contents.separate)
      result.push_back((path == "/" ? path : path + "/") + name);
  }
  return result;
}

Layout find_table(const Object& file, const std::string& path) {
  const std::string& chosen = path.empty() ? only_table_of(file) : path;
  return hdf5::kind_of(file, chosen) == hdf5::PathKind::dataset ? layout_of_dataset(file, chosen)
                                                                : layout_of_group(file, chosen);
}

Values read_rows(const Layout& layout, std::size_t column, const hdf5::RowRange& rows) {
  const ColumnPlace& place = layout.places[column];
  return hdf5::read_values(*place.dataset, place.part, rows);
}

Table read_all(const Layout& layout) {
  std::vector<Column> columns = layout.header.columns();
  for (std::size_t first = 0; first < columns.size();) {
    std::size_t last = first + 1;
    while (last < columns.size() && layout.places[last].dataset == layout.places[first].dataset)
      ++last;
    const hsize_t block = block_rows(layout, layout.places[first], last > first + 1);
    for (std::size_t j = first; j < last; ++j)
      columns[j].values = read_rows(layout, j, {0, std::min(block, layout.rows)});
    for (hsize_t row = block; row < layout.rows; row += block)
      for (std::size_t j = first; j < last; ++j)
        append(columns[j].values, read_rows(layout, j, {row, std::min(block, layout.rows - row)}));
    first = last;
  }
  Table table;
  table.attributes = layout.header.attributes;
  for (Column& column : columns) table.add(std::move(column));
  return table;
}

}  // namespace repose::table
