// The records of a run as tables and attributes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/scene/run_records.hpp"
#include "repose/table/table.hpp"
#include "row_table.hpp"

namespace repose::scene {

/// Columns of the time series of a case.
std::vector<ColumnHead> series_heads(const Case& scene);
std::vector<ColumnHead> wall_heads(const Case& scene);
std::vector<ColumnHead> contact_heads(const Case& scene);
std::vector<ColumnHead> energy_heads();

/// Values of a row in the order of its columns.
std::vector<double> values_of(const SeriesRow& row);
std::vector<double> values_of(const WallRow& row);
std::vector<double> values_of(const ContactRow& row);
std::vector<double> values_of(const EnergyRow& row);

table::Table table_of(const Snapshot& snapshot);
/// `file` stands in messages. Throws StorageError for a table that is no snapshot.
Snapshot snapshot_of(const table::Table& table, const std::filesystem::path& file);

table::Attributes attributes_of(const RunSummary& summary, const std::string& case_text);
/// Throws StorageError for attributes that are not those of a run.
RunSummary summary_of(const table::Attributes& attributes, const std::filesystem::path& file);

/// An attribute of a given type.
template <class T>
T attribute(const table::Attributes& attributes, const std::string& name,
            const std::filesystem::path& file) {
  const auto found = attributes.find(name);
  if (found == attributes.end())
    throw StorageError(file.string() + ": attribute \"" + name +
                       "\" is missing; this is not a run of repose");
  if (const T* value = std::get_if<T>(&found->second)) return *value;
  throw StorageError(file.string() + ": attribute \"" + name +
                     "\" has another type than a run of repose");
}

}  // namespace repose::scene
