#include "checks.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"

namespace repose::table {
void refuse_cell(std::string_view column, std::size_t row, const std::string& where,
                 const char* why) {
  throw InputError(fmt::format("{}: row {} of column \"{}\" {}", where, row + 1, column, why));
}

void refuse_values(const Values& values, std::string_view column, std::size_t first,
                   const std::string& where, Missing missing) {
  const auto* doubles = std::get_if<std::vector<double>>(&values);
  if (doubles == nullptr) return;
  for (std::size_t row = 0; row < doubles->size(); ++row) {
    if (std::isfinite((*doubles)[row])) continue;
    if (std::isinf((*doubles)[row]))
      refuse_cell(column, first + row, where,
                  "is infinite; values must be finite, and NaN where there is none");
    if (missing == Missing::refuse) refuse_cell(column, first + row, where, kMissingReason);
  }
}

void refuse_values(const Table& table, const std::string& where, Missing missing) {
  for (const Column& column : table.columns())
    refuse_values(column.values, column.name, 0, where, missing);
}

void refuse_nul(const std::string& text, const std::string& where) {
  if (text.find('\0') == std::string::npos) return;
  throw InputError(fmt::format(
      "{}: the text \"{}\" goes on after a NUL character, which HDF5 cannot store; remove it",
      where, text.substr(0, text.find('\0'))));
}

void refuse_nul(const Values& values, const std::string& where) {
  if (const auto* texts = std::get_if<std::vector<std::string>>(&values))
    for (const std::string& text : *texts) refuse_nul(text, where);
}

}  // namespace repose::table
