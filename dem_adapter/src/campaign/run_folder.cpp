#include "run_folder.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "outcome_json.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

namespace fs = std::filesystem;

void remove_whole(const fs::path& place) {
  std::error_code code;
  fs::remove_all(place, code);
  if (code)
    throw StorageError(fmt::format("cannot remove '{}': {}", place.string(), code.message()));
}

fs::path parts_file(const fs::path& folder) {
  return folder / "parts.json";
}

fs::path finished_file(const fs::path& folder) {
  return folder / "finished.json";
}

std::optional<Resources> finished_before(const fs::path& folder) {
  if (!fs::exists(finished_file(folder))) return std::nullopt;
  try {
    return parse_resources(read_file(finished_file(folder)));
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

void prepare_folder(const fs::path& folder, const std::string& case_text) {
  if (!fs::exists(scene::checkpoint_file(folder / "output"))) {
    for (const auto& place :
         {folder / "output", folder / "engine.log", parts_file(folder), finished_file(folder)})
      remove_whole(place);
  }
  const auto case_file = folder / "case.toml";
  if (!fs::exists(case_file) || read_file(case_file) != case_text)
    write_file_atomically(case_file, case_text);
}

void copy_output(const fs::path& from, const fs::path& to) {
  const auto half = to / "output.half";
  remove_whole(half);
  remove_whole(to / "output");
  std::error_code code;
  fs::copy(from / "output", half, fs::copy_options::recursive, code);
  if (!code) fs::rename(half, to / "output", code);
  if (code)
    throw StorageError(fmt::format("cannot copy '{}' to '{}': {}", (from / "output").string(),
                                   to.string(), code.message()));
}

}  // namespace repose::dem_adapter
