// Small helpers for names and numbers in messages and files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace repose {

/// The shortest decimal text that reads back as the same double.
std::string shortest(double value);

/// "a, b and c".
std::string listed(const std::vector<std::string>& names);

/// The candidate closest to `name` by edit distance if it is close enough to be a slip, else "".
std::string closest_name(std::string_view name, const std::vector<std::string>& candidates);

/// FNV-1a, 64 bits: names runs by the content of their inputs.
std::uint64_t content_hash(std::string_view text);

/// "1 h 02 min", "3 min 20 s", "12 s".
std::string duration_text(double seconds);

/// The version of repose, e.g. "0.1.0".
const char* version();

}  // namespace repose
