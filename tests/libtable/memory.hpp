// How much memory this process holds at most between two moments.
#pragma once

#include <cstddef>
#include <fstream>
#include <string>

namespace repose::table {

/// Largest resident size since reset_peak(), in bytes.
inline std::size_t peak_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stoul(line.substr(6)) * 1024;
  return 0;
}
inline void reset_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace repose::table
