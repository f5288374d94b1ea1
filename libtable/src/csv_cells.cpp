#include "csv_cells.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdlib>

#include "repose/base/error.hpp"

namespace repose::table {
namespace {

class Splitter {
 public:
  Splitter(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  CellGrid run() {
    while (position_ < text_.size()) {
      if (skip_empty_line()) continue;
      if (grid_.header.empty())
        read_line(grid_.header);
      else
        read_row();
    }
    if (grid_.header.empty())
      throw InputError(fmt::format("{} is empty; its first line must name the columns", name_));
    return std::move(grid_);
  }

 private:
  bool at_line_end() const {
    return text_.substr(position_, 2) == "\r\n" || text_[position_] == '\n';
  }

  void pass_line_end() {
    position_ += text_[position_] == '\r' ? 2 : 1;
    ++line_;
  }

  bool skip_empty_line() {
    if (!at_line_end()) return false;
    pass_line_end();
    return true;
  }

  void read_row() {
    const std::size_t first_line = line_;
    const std::size_t before = grid_.cells.size();
    read_line(grid_.cells);
    const std::size_t found = grid_.cells.size() - before;
    if (found != grid_.columns())
      throw InputError(
          fmt::format("{}, line {}: there are {} cells, but the first line names {} "
                      "columns",
                      name_, first_line, found, grid_.columns()));
  }

  void read_line(std::vector<Cell>& cells) {
    for (;;) {
      cells.push_back(next_cell());
      if (position_ == text_.size()) return;
      if (text_[position_] != ',') return pass_line_end();
      ++position_;
      if (position_ == text_.size()) return cells.push_back({});  // "a," at the end of the text
    }
  }

  /// Stops at a comma, a line's end or the end of the text.
  Cell next_cell() {
    if (position_ < text_.size() && text_[position_] == '"') return quoted_cell();
    const std::size_t start = position_;
    const std::size_t end = std::min(text_.find_first_of(",\n", start), text_.size());
    position_ = end;
    if (end < text_.size() && text_[end] == '\n' && end > start && text_[end - 1] == '\r')
      --position_;
    return {text_.substr(start, position_ - start), false};
  }

  Cell quoted_cell() {
    const std::size_t first_line = line_;
    const std::size_t start = ++position_;
    bool has_escapes = false;
    for (;; ++position_) {
      if (position_ == text_.size())
        throw InputError(
            fmt::format("{}, line {}: a quoted cell is never closed", name_, first_line));
      if (text_[position_] == '\n') ++line_;
      if (text_[position_] != '"') continue;
      if (text_.substr(position_, 2) != "\"\"") break;
      has_escapes = true;
      ++position_;
    }
    const std::string_view inside = text_.substr(start, position_ - start);
    ++position_;
    if (position_ < text_.size() && text_[position_] != ',' && !at_line_end())
      throw InputError(fmt::format(
          "{}, line {}: text goes on after a closing quote; a quote inside a cell is written twice",
          name_, line_));
    return {has_escapes ? unescape(inside) : inside, true};
  }

  std::string_view unescape(std::string_view text) {
    std::string& result = grid_.unescaped.emplace_back();
    for (std::size_t i = 0; i < text.size(); ++i) {
      result += text[i];
      if (text[i] == '"') ++i;
    }
    return result;
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t position_ = 0;
  std::size_t line_ = 1;
  CellGrid grid_;
};

}  // namespace

CellGrid split_cells(std::string_view text, const std::string& name) {
  return Splitter(text, name).run();
}

std::string_view without_blanks_around(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::optional<double> number_in(std::string_view text) {
  text = without_blanks_around(text);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (stop != end || code == std::errc::invalid_argument) return std::nullopt;
  // from_chars does not say on which side a number is out of range; strtod does.
  if (code == std::errc::result_out_of_range)
    return std::strtod(std::string(text).c_str(), nullptr);
  return value;
}

}  // namespace repose::table
