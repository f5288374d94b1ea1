#include "checks.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"

namespace repose::table {
namespace {

template <class Predicate>
void refuse(const Table& table, const std::string& where, Predicate is_refused, const char* why) {
  for (const Column& column : table.columns()) {
    const auto* values = std::get_if<std::vector<double>>(&column.values);
    if (values == nullptr) continue;
    for (std::size_t row = 0; row < values->size(); ++row)
      if (is_refused((*values)[row])) refuse_cell(column.name, row, where, why);
  }
}

}  // namespace

void refuse_cell(std::string_view column, std::size_t row, const std::string& where,
                 const char* why) {
  throw InputError(fmt::format("{}: row {} of column \"{}\" {}", where, row + 1, column, why));
}

void refuse_infinite(const Table& table, const std::string& where) {
  refuse(
      table, where, [](double value) { return std::isinf(value); },
      "is infinite; values must be finite, and NaN where there is none");
}

void refuse_missing(const Table& table, const std::string& where) {
  refuse(
      table, where, [](double value) { return std::isnan(value); }, kMissingReason);
}

void refuse_nul(const std::string& text, const std::string& where) {
  if (text.find('\0') == std::string::npos) return;
  throw InputError(fmt::format(
      "{}: the text \"{}\" goes on after a NUL character, which HDF5 cannot store; remove it",
      where, text.substr(0, text.find('\0'))));
}

}  // namespace repose::table
