#include "placeholders.hpp"

#include <fmt/format.h>

#include <cctype>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

bool begins_name(char c) {
  const auto u = static_cast<unsigned char>(c);
  return u < 0x80 && (std::isalpha(u) != 0 || c == '_');
}

/// Calls plain(text) for what stands as it is and found(name, line) for each placeholder, in order.
template <class Plain, class Found>
void scan(std::string_view text, Plain plain, Found found) {
  std::size_t line = 1, from = 0, at = 0;
  while (at < text.size()) {
    if (text[at] == '\n') ++line;
    if (text.substr(at, 3) == "$${") {
      plain(text.substr(from, at - from));
      from = at + 1;  // the second $ and what follows stand as they are
      at += 3;
      continue;
    }
    if (text.substr(at, 2) != "${") {
      ++at;
      continue;
    }
    std::size_t end = at + 2;
    while (end < text.size() &&
           (begins_name(text[end]) || (end > at + 2 && text[end] >= '0' && text[end] <= '9')))
      ++end;
    if (end == at + 2 || end >= text.size() || text[end] != '}')
      throw InputError(fmt::format(
          "line {}: \"{}\" is no placeholder; write ${{NAME}} with letters, digits and _, or $${{ "
          "for a plain ${{",
          line, text.substr(at, std::min(text.find('\n', at), at + 20) - at)));
    plain(text.substr(from, at - from));
    found(std::string(text.substr(at + 2, end - at - 2)), line);
    from = at = end + 1;
  }
  plain(text.substr(from));
}

}  // namespace

std::vector<Placeholder> placeholders_of(std::string_view text) {
  std::vector<Placeholder> all;
  scan(
      text, [](std::string_view) {},
      [&](std::string name, std::size_t line) {
        all.push_back({std::move(name), line});
      });
  return all;
}

std::string filled_in(std::string_view text, const std::map<std::string, std::string>& values) {
  std::string result;
  scan(
      text, [&](std::string_view plain) { result += plain; },
      [&](const std::string& name, std::size_t) {
        const auto value = values.find(name);
        REPOSE_ASSERT(value != values.end(), name);
        result += value->second;
      });
  return result;
}

}  // namespace repose::dem_adapter
