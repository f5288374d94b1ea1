// outcome.json of a run: KPIs, details, failure, engine and time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "repose/dem_adapter/campaign.hpp"

namespace repose::dem_adapter {

/// Empty if there is no such file. Throws StorageError if it is damaged.
std::optional<RunOutcome> read_outcome(const std::filesystem::path& file);

void write_outcome(const std::filesystem::path& file, const RunOutcome& outcome,
                   const std::string& engine);

}  // namespace repose::dem_adapter
