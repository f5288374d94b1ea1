// The folder of a run before its engine begins.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "repose/dem_adapter/outcome.hpp"

namespace repose::dem_adapter {

/// What earlier parts of a run used, beside its case.
std::filesystem::path parts_file(const std::filesystem::path& folder);

/// Resources of an engine that finished before its output was measured: the campaign was stopped
/// in between.
std::filesystem::path finished_file(const std::filesystem::path& folder);
std::optional<Resources> finished_before(const std::filesystem::path& folder);

/// Writes case.toml. Leaves the rest as it is if the engine can go on in it, else removes what an
/// engine wrote. Throws StorageError.
void prepare_folder(const std::filesystem::path& folder, const std::string& case_text);

/// Removes a file or folder that may not be there. Throws StorageError.
void remove_whole(const std::filesystem::path& place);

/// Copies the engine's output from one run's folder to another's, which then has all of it or
/// none. Throws StorageError.
void copy_output(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace repose::dem_adapter
