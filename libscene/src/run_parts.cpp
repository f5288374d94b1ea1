#include "run_parts.hpp"

#include <string>
#include <system_error>

#include "repose/base/error.hpp"

namespace repose::scene {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_remove(const fs::path& path, const std::error_code& error) {
  throw StorageError(path.string() + ": cannot be removed: " + error.message() +
                     "; remove it by hand or choose another folder");
}

}  // namespace

void require_part(const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw StorageError(file.string() +
                       ": is missing; without it this run cannot go on, begin it anew");
}

bool remove_part(const fs::path& file) {
  std::error_code error;
  const bool removed = fs::remove(file, error);
  if (error) cannot_remove(file, error);
  return removed;
}

void remove_tree(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) cannot_remove(path, error);
}

void remove_unfinished(const fs::path& folder) {
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') && name.find(".tmp") != std::string::npos) remove_part(entry.path());
  }
}

}  // namespace repose::scene
