#include "case_io/values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {

Vec3 vector3(const TomlTable& table, const char* key) {
  const std::vector<double> values = table.numbers(key);
  if (values.size() != 3)
    table.fail(key, "has " + std::to_string(values.size()) + " numbers; give three, [x, y, z]");
  return {values[0], values[1], values[2]};
}

Vec3 vector3_or(const TomlTable& table, const char* key, const Vec3& fallback) {
  return table.has(key) ? vector3(table, key) : fallback;
}

std::vector<std::string> texts_or_none(const TomlTable& table, const char* key) {
  return table.has(key) ? table.texts(key) : std::vector<std::string>{};
}

std::filesystem::path absolute_from(const Folder& folder, const std::filesystem::path& file) {
  if (folder.empty() || file.is_absolute()) return file;
  return std::filesystem::absolute(folder / file).lexically_normal();
}

std::uint64_t read_content_hash(const TomlTable& table, const Folder& folder,
                                const std::filesystem::path& file) {
  if (table.has("content_hash")) {
    const std::string text = table.text("content_hash");
    std::uint64_t hash = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, code] = std::from_chars(text.data(), end, hash, 16);
    if (code != std::errc{} || stop != end)
      table.fail("content_hash",
                 "\"" + text +
                     "\" is not a hash of 16 hexadecimal digits; take it out to use the "
                     "file as it is");
    return hash;
  }
  if (folder.empty()) return 0;
  try {
    return content_hash(read_file(file));
  } catch (const StorageError& error) {
    table.fail("file", error.what());
  }
}

std::string number_text(double value) {
  std::string text = shortest(value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string vector_text(const Vec3& v) {
  return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]";
}

void CaseText::put(const std::string& key, const std::vector<std::string>& value) {
  std::string list;
  for (const std::string& name : value) list += (list.empty() ? "" : ", ") + toml_quoted(name);
  raw(key, "[" + list + "]");
}

void CaseText::put_if_any(const std::string& key, const std::string& value) {
  if (!value.empty()) put(key, value);
}

void CaseText::put_hash(std::uint64_t content_hash) {
  if (content_hash != 0) put("content_hash", fmt::format("{:016x}", content_hash));
}

}  // namespace repose::scene
