#include "superblock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string_view>

#include "repose/base/error.hpp"

namespace repose::table::hdf5 {
namespace {

/// The longest part of a superblock that we look at: version 1 with addresses of 8 bytes.
using Start = std::array<char, 64>;

/// The superblock: at the start of the file or behind a user block of 512, 1024, 2048, ... bytes.
std::optional<Start> superblock(std::ifstream& file) {
  constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
  for (std::streamoff at = 0;; at = at == 0 ? 512 : 2 * at) {
    Start start{};
    file.clear();
    if (!file.seekg(at) || (file.read(start.data(), start.size()), file.gcount() == 0))
      return std::nullopt;
    if (std::string_view(start.data(), kSignature.size()) == kSignature) return start;
  }
}

}  // namespace

void refuse_driver_information(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::optional<Start> start = superblock(file);
  if (!start) return;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>((*start)[i]); };
  const std::size_t version = byte(8), address_bytes = byte(13);
  // Later versions have none; HDF5 refuses other sizes.
  if (version > 1 || (address_bytes != 2 && address_bytes != 4 && address_bytes != 8)) return;
  // Behind the addresses of base, free space and end of file; all ones where there is no block.
  const auto* const address = start->data() + (version == 0 ? 24 : 28) + 3 * address_bytes;
  if (std::all_of(address, address + address_bytes, [](char c) { return c == '\xff'; })) return;
  throw StorageError(
      fmt::format("cannot read {}: it is damaged, or one part of a file that HDF5 split over "
                  "several; make one file of them with h5repack",
                  path.string()));
}

}  // namespace repose::table::hdf5
