// Columns of a table from the members of records, and back.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "repose/dem/contact_law.hpp"
#include "repose/table/table.hpp"

namespace repose::dem {

/// A table with one row for each of `rows` records, which are asked for by their number.
class TableBuilder {
 public:
  explicit TableBuilder(std::size_t rows) : rows_(rows) {}

  template <class Get>
  void integers(const std::string& name, Get get) {
    std::vector<std::int64_t> values;
    values.reserve(rows_);
    for (std::size_t r = 0; r < rows_; ++r) values.push_back(get(r));
    table_.add({.name = name, .values = std::move(values)});
  }
  template <class Get>
  void numbers(const std::string& name, const std::string& unit, Get get) {
    std::vector<double> values;
    values.reserve(rows_);
    for (std::size_t r = 0; r < rows_; ++r) values.push_back(get(r));
    table_.add({.name = name, .unit = unit, .values = std::move(values)});
  }
  template <class Get>
  void texts(const std::string& name, Get get) {
    std::vector<std::string> values;
    for (std::size_t r = 0; r < rows_; ++r) values.push_back(get(r));
    table_.add({.name = name, .values = std::move(values)});
  }
  /// Three columns name_x, name_y, name_z.
  template <class Get>
  void vectors(const std::string& name, const std::string& unit, Get get) {
    for (int k = 0; k < 3; ++k)
      numbers(name + "_" + "xyz"[k], unit, [&](std::size_t r) { return get(r)[k]; });
  }
  table::Table take() { return std::move(table_); }

 private:
  std::size_t rows_;
  table::Table table_;
};

/// The columns name_x, name_y and name_z of a table.
class VectorColumn {
 public:
  VectorColumn(const table::Table& table, const std::string& name)
      : x_(table.numbers(name + "_x")),
        y_(table.numbers(name + "_y")),
        z_(table.numbers(name + "_z")) {}
  Vec3 operator[](std::size_t row) const { return {x_[row], y_[row], z_[row]}; }

 private:
  std::vector<double> x_, y_, z_;
};

/// A column of integers that the engine keeps in 32 bits.
inline std::vector<std::int32_t> short_integers(const table::Table& table,
                                                const std::string& name) {
  const std::vector<std::int64_t> values = table.integers(name);
  return {values.begin(), values.end()};
}

}  // namespace repose::dem
