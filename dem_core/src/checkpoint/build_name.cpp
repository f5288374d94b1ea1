#include "checkpoint/build_name.hpp"

#include <fmt/format.h>
#include <link.h>

#include <fstream>

#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

/// Appends what the program's file holds of its segments that are never written to: no data that
/// changes as it runs, nothing for debuggers.
int append_constant_segments(dl_phdr_info* program, std::size_t, void* text) {
  std::ifstream file("/proc/self/exe", std::ios::binary);
  for (int s = 0; s < program->dlpi_phnum; ++s) {
    const ElfW(Phdr)& segment = program->dlpi_phdr[s];
    if (segment.p_type != PT_LOAD || (segment.p_flags & PF_W) != 0) continue;
    std::string bytes(segment.p_filesz, '\0');
    file.seekg(static_cast<std::streamoff>(segment.p_offset));
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    *static_cast<std::string*>(text) += bytes;
  }
  return 1;  // the first is the program itself; its libraries are not asked for
}

}  // namespace

std::string build_name() {
  static const std::string name = [] {
    std::string segments;
    dl_iterate_phdr(append_constant_segments, &segments);
    return fmt::format("{} build {:016x}", version(), content_hash(segments));
  }();
  return name;
}

}  // namespace repose::dem
