#include "repose/dem/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <string_view>
#include <system_error>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"

namespace repose::dem {
namespace {

constexpr std::int64_t kFormat = 3;  // of the file
constexpr const char* kFormatName = "repose_checkpoint";
constexpr const char* kFreeKey = "checkpoint_wall_time_s = ";

// Behind the HDF5 part of the file, which ends where its superblock says: the hash of all bytes
// before. HDF5 itself can crash on damaged files, so that it must not see one.
constexpr std::string_view kTrailer = "\nrepose checksum ";
constexpr std::size_t kTrailerLength = kTrailer.size() + 16 + 1;

std::string trailer_of(std::string_view text) {
  return fmt::format("{}{:016x}\n", kTrailer, content_hash(text));
}

bool is_whole(std::string_view text) {
  if (text.size() < kTrailerLength) return false;
  const std::size_t length = text.size() - kTrailerLength;
  return text.substr(length) == trailer_of(text.substr(0, length));
}

void append(const std::filesystem::path& file, const std::string& text) {
  std::FILE* const out = std::fopen(file.c_str(), "ab");
  const bool is_open = out != nullptr;
  const bool is_written = is_open && std::fwrite(text.data(), 1, text.size(), out) == text.size();
  if ((is_open && std::fclose(out) != 0) || !is_written)
    throw StorageError(fmt::format("cannot write '{}': {}", file.string(), std::strerror(errno)));
}

table::Attributes file_attributes(const Checkpoint& checkpoint) {
  table::Attributes attributes = checkpoint.attributes;
  attributes["case"] = checkpoint.case_text;
  return attributes;
}

template <class T>
T attribute(const table::Attributes& attributes, const std::string& name) {
  const auto found = attributes.find(name);
  const T* const value = found == attributes.end() ? nullptr : std::get_if<T>(&found->second);
  if (value == nullptr)
    throw StorageError("a checkpoint without \"" + name +
                       "\" is not one of this version of repose-dem; begin the run anew");
  return *value;
}

[[noreturn]] void damaged(const std::filesystem::path& file, const std::string& why) {
  throw StorageError(file.string() + ": " + why +
                     "; remove it or begin the run anew (--from-start)");
}

/// Lines of a case with the section that each belongs to.
struct Line {
  std::string section = "its first keys";
  std::string text;
};
std::vector<Line> lines_of(const std::string& case_text) {
  std::vector<Line> lines;
  std::istringstream in(case_text);
  Line line;
  while (std::getline(in, line.text)) {
    if (line.text.starts_with('[')) line.section = line.text;
    if (!line.text.empty() && !line.text.starts_with(kFreeKey)) lines.push_back(line);
  }
  return lines;
}

std::string quoted_or_nothing(const Line* line) {
  constexpr std::size_t kLongest = 120;
  return line == nullptr                 ? "nothing"
         : line->text.size() <= kLongest ? '"' + line->text + '"'
                                         : '"' + line->text.substr(0, kLongest) + "...\"";
}

}  // namespace

const table::Table& Checkpoint::table(const std::string& path) const {
  for (const auto& [name, table] : tables)
    if (name == path) return table;
  throw StorageError("a checkpoint without the table " + path +
                     " is not one of this version of repose-dem; begin the run anew");
}

double Checkpoint::number(const std::string& name) const {
  return attribute<double>(attributes, name);
}

std::int64_t Checkpoint::integer(const std::string& name) const {
  return attribute<std::int64_t>(attributes, name);
}

std::vector<double> Checkpoint::numbers(const std::string& name, std::size_t count) const {
  std::vector<double> values = attribute<std::vector<double>>(attributes, name);
  if (values.size() != count)
    throw StorageError(
        fmt::format("\"{}\" of a checkpoint has {} numbers for {}", name, values.size(), count));
  return values;
}

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  table::Attributes attributes = file_attributes(checkpoint);
  attributes[kFormatName] = kFormat;
  const std::filesystem::path temporary = temporary_beside(file);
  try {
    table::write_tables(temporary, checkpoint.tables, attributes);
    append(temporary, trailer_of(read_file(temporary)));
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw;
  }
  commit_file(temporary, file);
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
  if (!is_whole(read_file(file))) damaged(file, "is damaged, its checksum is wrong");
  Checkpoint checkpoint;
  table::Attributes attributes = table::read_attributes({file, "/"});
  const auto format = attributes.find(kFormatName);
  if (format == attributes.end()) damaged(file, "is not a checkpoint of repose-dem");
  if (format->second != table::Attribute(kFormat))
    damaged(file, "was written by another version of repose-dem");
  for (const std::string& path : table::list_tables(file))
    checkpoint.tables.emplace_back(path, table::read_table({file, path}));
  checkpoint.case_text = attribute<std::string>(attributes, "case");
  checkpoint.attributes = std::move(attributes);
  return checkpoint;
}

void require_same_beginning(const Checkpoint& checkpoint, const scene::Case& scene) {
  const std::size_t begun = checkpoint.table("/stages").rows();
  const auto beginning_lines = [&](const scene::Case& of) {
    return lines_of(scene::case_text(scene::beginning_of(of, begun)));
  };
  const std::vector<Line> before =
      beginning_lines(scene::parse_case(checkpoint.case_text, "the case of the checkpoint"));
  const std::vector<Line> now = beginning_lines(scene);
  for (std::size_t l = 0; l < std::max(before.size(), now.size()); ++l) {
    const Line* const was = l < before.size() ? &before[l] : nullptr;
    const Line* const is = l < now.size() ? &now[l] : nullptr;
    if (was != nullptr && is != nullptr && was->text == is->text) continue;
    throw InputError(fmt::format(
        "the checkpoint is of another case: in {} it had {} where this case has {}; give the case "
        "back, choose another folder or begin the run anew (--from-start)",
        is != nullptr ? is->section : was->section, quoted_or_nothing(was), quoted_or_nothing(is)));
  }
}

}  // namespace repose::dem
