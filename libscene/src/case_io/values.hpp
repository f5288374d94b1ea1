// Vectors and files of a case file, and the lines that are written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "repose/base/toml.hpp"
#include "repose/scene/grains.hpp"

namespace repose::scene {

/// Three numbers, [x, y, z].
Vec3 vector3(const TomlTable& table, const char* key);
Vec3 vector3_or(const TomlTable& table, const char* key, const Vec3& fallback);
/// A list of texts, empty if absent.
std::vector<std::string> texts_or_none(const TomlTable& table, const char* key);

/// Where relative paths of a case file start; empty leaves them as they are, unread.
using Folder = std::filesystem::path;

/// `file` from `folder`, absolute. Nothing is looked up on disk.
std::filesystem::path absolute_from(const Folder& folder, const std::filesystem::path& file);
/// The key content_hash if it is there; else the hash of `file`, 0 if there is no folder. Fails on
/// the key "file" if that cannot be read.
std::uint64_t read_content_hash(const TomlTable& table, const Folder& folder,
                                const std::filesystem::path& file);

/// A TOML float, so that -0.0 and whole numbers keep type and bits.
std::string number_text(double value);
std::string vector_text(const Vec3& v);

/// Collects the lines of a case file.
struct CaseText {
  std::string text{};
  void heading(const std::string& name) { text += "\n" + name + "\n"; }
  void raw(const std::string& key, const std::string& value) { text += key + " = " + value + "\n"; }
  void put(const std::string& key, double value) { raw(key, number_text(value)); }
  void put(const std::string& key, const std::string& value) { raw(key, toml_quoted(value)); }
  void put(const std::string& key, const char* value) { put(key, std::string(value)); }
  void put(const std::string& key, const Vec3& value) { raw(key, vector_text(value)); }
  void put(const std::string& key, const std::vector<std::string>& value);
  void put_flag(const std::string& key, bool value) { raw(key, value ? "true" : "false"); }
  /// Nothing if the text is empty.
  void put_if_any(const std::string& key, const std::string& value);
  /// Nothing if the hash is 0.
  void put_hash(std::uint64_t content_hash);
};

}  // namespace repose::scene
