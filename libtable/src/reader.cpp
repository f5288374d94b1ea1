#include "repose/table/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "checks.hpp"
#include "layout.hpp"
#include "repose/base/error.hpp"
#include "write.hpp"

namespace repose::table {
namespace {

/// Rows of a block; a multiple of most chunks.
constexpr std::size_t kBlockRows = 128 * 1024;

Values part_of(const Values& values, std::size_t first, std::size_t count) {
  return std::visit(
      [&](const auto& all) -> Values {
        const auto from = all.begin() + static_cast<std::ptrdiff_t>(first);
        return std::decay_t<decltype(all)>(from, from + static_cast<std::ptrdiff_t>(count));
      },
      values);
}

Table without_values(const Table& table) {
  Table header;
  for (const Column& column : table.columns())
    header.add({column.name, column.unit, column.role, column.range, part_of(column.values, 0, 0)});
  header.attributes = table.attributes;
  return header;
}

}  // namespace

struct TableReader::State {
  std::string where;
  Missing missing;
  Table header;
  std::size_t rows = 0;
  std::optional<Table> csv;
  std::optional<hdf5::Object> file;
  Layout layout;

  State(const Location& location, Missing allowed)
      : where(location_text(location)), missing(allowed) {
    if (is_csv(location.file)) {
      csv = read_csv(location.file, missing);
      header = without_values(*csv);
      rows = csv->rows();
      return;
    }
    const hdf5::Session session;
    file.emplace(hdf5::open_file(location.file));
    layout = find_table(*file, location.group);
    for (std::size_t j = 0; j < layout.places.size(); ++j) {
      Column column = layout.header.columns()[j];
      column.values = read_rows(layout, j, {0, 0});  // of the type that the file has
      header.add(std::move(column));
    }
    header.attributes = layout.header.attributes;
    rows = static_cast<std::size_t>(layout.rows);
  }
  ~State() {
    const hdf5::Session session;
    layout = {};
    file.reset();
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  std::size_t index_of(std::string_view column) const {
    const Column* const found = &header.column(column);
    return static_cast<std::size_t>(found - header.columns().data());
  }

  Values read(std::size_t column, std::size_t first, std::size_t count) const {
    if (csv) return part_of(csv->columns()[column].values, first, count);
    Values values;
    {
      const hdf5::Session session;
      values = read_rows(layout, column, {first, count});
    }
    refuse_values(values, header.columns()[column].name, first, where, missing);
    return values;
  }
};

TableReader::TableReader(const Location& location, Missing missing)
    : state_(std::make_unique<State>(location, missing)) {}
TableReader::TableReader(TableReader&&) noexcept = default;
TableReader& TableReader::operator=(TableReader&&) noexcept = default;
TableReader::~TableReader() = default;

const Table& TableReader::header() const {
  return state_->header;
}

std::size_t TableReader::rows() const {
  return state_->rows;
}

Values TableReader::values(std::string_view column, std::size_t first, std::size_t count) const {
  const std::size_t index = state_->index_of(column);
  if (first > rows() || count > rows() - first)
    throw InputError(fmt::format("{} rows from row {} on are asked of {}, which has {}", count,
                                 first + 1, state_->where, rows()));
  return state_->read(index, first, count);
}

void TableReader::for_each_block(
    std::string_view column,
    const std::function<void(std::size_t first, Values values)>& take) const {
  const std::size_t index = state_->index_of(column);
  for (std::size_t first = 0; first < rows(); first += kBlockRows)
    take(first, state_->read(index, first, std::min(kBlockRows, rows() - first)));
}

}  // namespace repose::table
