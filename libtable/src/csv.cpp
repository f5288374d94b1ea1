// CSV: what the cells of a column mean, and writing them so that they mean the same again.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "checks.hpp"
#include "csv_cells.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "write.hpp"
#include "writer_lock.hpp"

namespace repose::table {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// ---- reading

/// The cells below one name.
struct CellColumn {
  const CellGrid& grid;
  std::size_t index;
  bool quotes_mean_text;

  std::size_t rows() const { return grid.rows(); }
  const Cell& operator[](std::size_t row) const { return grid.cells[row * grid.columns() + index]; }
  bool is_text(const Cell& cell) const { return cell.quoted && quotes_mean_text; }
};

bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    if (lead < 0x80) continue;
    const int more = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : 1;
    if (lead < 0xc2 || lead > 0xf4) return false;
    for (int k = 0; k < more; ++k, ++i)
      if (i == text.size() || (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return false;
  }
  return true;
}

std::optional<std::int64_t> integer_in(std::string_view text) {
  text = without_blanks_around(text);
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (stop != end || code != std::errc{}) return std::nullopt;
  return value;
}

std::optional<std::vector<std::int64_t>> as_integers(const CellColumn& cells) {
  if (cells.rows() == 0) return std::nullopt;
  std::vector<std::int64_t> values;
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const auto value = integer_in(cells[row].text);
    if (!value || cells.is_text(cells[row])) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

std::optional<std::vector<double>> as_numbers(const CellColumn& cells) {
  std::vector<double> values;
  values.reserve(cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const bool is_empty = without_blanks_around(cells[row].text).empty();
    const auto value = is_empty ? std::nan("") : number_in(cells[row].text);
    if (!value || cells.is_text(cells[row])) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

std::vector<std::string> as_texts(const CellColumn& cells, std::string_view column, Missing missing,
                                  const std::string& where) {
  std::vector<std::string> values;
  values.reserve(cells.rows());
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    const Cell& cell = cells[row];
    if (missing == Missing::refuse && !cell.quoted && cell.text.empty())
      refuse_cell(column, row, where, kMissingReason);
    values.emplace_back(cell.text);
  }
  return values;
}

/// "name [unit]", "name".
Column named_column(const Cell& header) {
  const std::string_view text = header.quoted ? header.text : without_blanks_around(header.text);
  const std::size_t bracket = text.rfind(" [");
  if (!text.ends_with(']') || bracket == std::string_view::npos || bracket == 0)
    return {.name = std::string(text)};
  return {.name = std::string(text.substr(0, bracket)),
          .unit = std::string(text.substr(bracket + 2, text.size() - bracket - 3))};
}

bool is_every_cell_quoted(const CellGrid& grid) {
  const auto quoted = [](const Cell& cell) { return cell.quoted; };
  return std::all_of(grid.header.begin(), grid.header.end(), quoted) &&
         std::all_of(grid.cells.begin(), grid.cells.end(), quoted);
}

// ---- writing

void append(std::string& out, double value) {
  if (std::isnan(value)) {
    out += "nan";
    return;
  }
  const std::string text = shortest(value);
  out += text;
  // The type of a column survives: 2.0 is not the integer 2.
  if (text.find_first_of(".e") == std::string::npos) out += ".0";
}

void append(std::string& out, std::int64_t value) {
  std::array<char, 24> buffer{};
  const auto [end, code] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  static_cast<void>(code);  // 24 characters hold every integer
  out.append(buffer.data(), end);
}

void append_quoted(std::string& out, std::string_view text) {
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

bool has_special_characters(std::string_view text) {
  return text.find_first_of(",\"\r\n") != std::string_view::npos ||
         without_blanks_around(text) != text;
}

void append(std::string& out, const std::string& text) {
  if (text.empty() || has_special_characters(text) || number_in(text))
    append_quoted(out, text);
  else
    out += text;
}

void append_header(std::string& out, const Column& column) {
  std::string text = column.name;
  if (column.unit != "1" || column.name.ends_with(']')) text += fmt::format(" [{}]", column.unit);
  if (has_special_characters(text) || text.starts_with(kByteOrderMark))
    append_quoted(out, text);
  else
    out += text;
}

}  // namespace

Table parse_csv(std::string_view text, const std::string& name, Missing missing) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (!is_utf8(text))
    throw InputError(fmt::format("{} is not UTF-8 text; save it as \"CSV UTF-8\"", name));
  const CellGrid grid = split_cells(text, name);
  const bool quotes_mean_text = !is_every_cell_quoted(grid);
  Table table;
  for (std::size_t j = 0; j < grid.columns(); ++j) {
    const CellColumn cells{grid, j, quotes_mean_text};
    Column column = named_column(grid.header[j]);
    if (auto integers = as_integers(cells))
      column.values = std::move(*integers);
    else if (auto numbers = as_numbers(cells))
      column.values = std::move(*numbers);
    else
      column.values = as_texts(cells, column.name, missing, name);
    try {
      table.add(std::move(column));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}, column {}: {}", name, j + 1, error.what()));
    }
  }
  refuse_values(table, name, missing);
  return table;
}

Table read_csv(const std::filesystem::path& file, Missing missing) {
  return parse_csv(read_file(file), file.string(), missing);
}

std::string csv_text(const Table& table) {
  refuse_values(table, "a table to be written as CSV", Missing::allow);
  return csv_header(table) + csv_rows(table);
}

std::string csv_header(const Table& table) {
  std::string out;
  for (const Column& column : table.columns()) {
    if (!out.empty()) out += ',';
    append_header(out, column);
  }
  return out + '\n';
}

std::string csv_rows(const Table& table) {
  std::string out;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    bool is_first = true;
    for (const Column& column : table.columns()) {
      if (!is_first) out += ',';
      is_first = false;
      std::visit([&](const auto& values) { append(out, values[row]); }, column.values);
    }
    out += '\n';
  }
  return out;
}

void write_csv(const std::filesystem::path& file, const Table& table) {
  const WriterLock lock(file);
  write_csv_locked(file, table);
}

void refuse_no_columns(const Table& table, const std::filesystem::path& file) {
  if (table.columns().empty())
    throw InputError(
        fmt::format("{}: a table without columns cannot be written as CSV", file.string()));
}

void write_csv_locked(const std::filesystem::path& file, const Table& table) {
  refuse_values(table, file.string(), Missing::allow);
  refuse_no_columns(table, file);
  write_file_atomically(file, csv_text(table));
}

}  // namespace repose::table
