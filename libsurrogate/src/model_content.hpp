// The content of model files in memory, for the sources that write and read a kind of model.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "repose/table/table.hpp"

namespace repose::surrogate {

/// What a model adds to what all files hold: kind, version, response, /inputs and /levels.
struct ModelContent {
  table::Attributes attributes = {};
  std::vector<std::pair<std::string, table::Table>> tables = {};

  /// A table without rows is left out; has_table() tells.
  void add(std::string group, table::Table table) {
    if (table.rows() > 0) tables.emplace_back(std::move(group), std::move(table));
  }
};

inline void add_column(table::Table& table, std::string name, table::Values values) {
  table.add({.name = std::move(name), .values = std::move(values)});
}

template <class Vectorlike>
std::vector<double> doubles(const Vectorlike& values) {
  std::vector<double> v(static_cast<std::size_t>(values.size()));
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = values[static_cast<Eigen::Index>(i)];
  return v;
}

inline Vector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// A model file whose every inconsistency is a StorageError that names the file. What tables say of
/// missing columns, an InputError, becomes one in load_regressor().
class ModelReader {
 public:
  explicit ModelReader(std::filesystem::path path);
  /// A model nested in this one: attributes NAME.attribute, tables /NAME/table.
  ModelReader below(const std::string& name) const;

  [[noreturn]] void damaged(const std::string& what) const;
  void check(bool holds, const char* what) const {
    if (!holds) damaged(what);
  }

  bool has(const std::string& name) const { return attributes_.contains(name); }
  template <class T>
  T get(const std::string& name) const {
    const auto found = attributes_.find(name);
    if (found == attributes_.end()) damaged(fmt::format("attribute '{}' is missing", name));
    const T* value = std::get_if<T>(&found->second);
    if (value == nullptr) damaged(fmt::format("attribute '{}' has the wrong type", name));
    return *value;
  }
  double positive_or_zero(const std::string& name) const;
  /// The value that to_string() gives this text.
  template <class Enum, std::size_t N>
  Enum choice(const std::string& text, const std::array<Enum, N>& values) const {
    for (const Enum value : values)
      if (text == to_string(value)) return value;
    damaged(fmt::format("'{}' is not known to this version", text));
  }
  std::string kind() const { return get<std::string>("repose_model"); }
  std::int64_t version() const { return get<std::int64_t>("model_version"); }

  bool has_table(const std::string& group) const;
  table::Table read(const std::string& group) const;

 private:
  std::filesystem::path path_;
  table::Attributes attributes_;
  std::string group_;  ///< "" or "/NAME"
};

}  // namespace repose::surrogate
