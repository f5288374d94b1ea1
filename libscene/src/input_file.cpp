#include "repose/scene/input_file.hpp"

#include <fmt/format.h>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {

std::string read_input_file(const std::filesystem::path& path, std::uint64_t hash) {
  std::string bytes = read_file(path);
  const std::uint64_t found = content_hash(bytes);
  if (hash != 0 && found != hash)
    throw InputError(
        fmt::format("{}: content_hash = {:016x}, but the case was written for {:016x}: the file "
                    "changed since; put the old file back, or take content_hash out of the case "
                    "to use the new one",
                    path.string(), found, hash));
  return bytes;
}

}  // namespace repose::scene
