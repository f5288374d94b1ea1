// Which build of the program this is.
#pragma once

#include <string>

namespace repose::dem {

/// Version and FNV-1a hash of the code and constants of the running program, such as "0.1.0 build
/// 0123456789abcdef": builds with other bits in their results have other names.
std::string build_name();

}  // namespace repose::dem
