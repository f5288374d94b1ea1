// The cells of a CSV text, before anyone asks what they mean.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace repose::table {

struct Cell {
  std::string_view text;  ///< without quotes
  bool quoted = false;
};

/// Cells of all lines, each as many as the first line has. Refers to the text that it was made
/// from.
struct CellGrid {
  std::vector<Cell> header;
  std::vector<Cell> cells;            ///< row after row
  std::deque<std::string> unescaped;  ///< cells in which "" stood for "
  std::size_t columns() const { return header.size(); }
  std::size_t rows() const { return header.empty() ? 0 : cells.size() / columns(); }
};

/// Splits RFC 4180 text without byte order mark; empty lines are skipped. `name` stands for the
/// file in messages. Throws InputError for lines of different length, an open quote or no line at
/// all.
CellGrid split_cells(std::string_view text, const std::string& name);

/// The number that all of `text` stands for, blanks around it aside; infinity if it is too large.
std::optional<double> number_in(std::string_view text);

std::string_view without_blanks_around(std::string_view text);

}  // namespace repose::table
