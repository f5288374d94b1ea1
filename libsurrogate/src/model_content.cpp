#include "model_content.hpp"

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/table/io.hpp"

namespace repose::surrogate {

ModelReader::ModelReader(std::filesystem::path path)
    : path_(std::move(path)), attributes_(table::read_attributes({path_, "/"})) {}

ModelReader ModelReader::below(const std::string& name) const {
  ModelReader nested = *this;
  nested.group_ += "/" + name;
  nested.attributes_.clear();
  for (const auto& [key, value] : attributes_)
    if (key.starts_with(name + ".")) nested.attributes_[key.substr(name.size() + 1)] = value;
  return nested;
}

void ModelReader::damaged(const std::string& what) const {
  throw StorageError(fmt::format("model file '{}': {}; fit the model again", path_.string(), what));
}

double ModelReader::positive_or_zero(const std::string& name) const {
  const double value = get<double>(name);
  if (!std::isfinite(value) || value < 0.0)
    damaged(fmt::format("attribute '{}' is {}, which must not be negative", name, value));
  return value;
}

bool ModelReader::has_table(const std::string& group) const {
  const auto tables = table::list_tables(path_);
  return std::find(tables.begin(), tables.end(), group_ + group) != tables.end();
}

table::Table ModelReader::read(const std::string& group) const {
  return table::read_table({path_, group_ + group});
}

}  // namespace repose::surrogate
