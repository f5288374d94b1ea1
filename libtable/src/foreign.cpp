#include "foreign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "repose/base/error.hpp"

namespace repose::table {
namespace {

/// A code point of the basic plane as UTF-8.
void append_utf8(std::string& out, unsigned code) {
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xc0 | (code >> 6));
    out += static_cast<char>(0x80 | (code & 0x3f));
  } else {
    out += static_cast<char>(0xe0 | (code >> 12));
    out += static_cast<char>(0x80 | ((code >> 6) & 0x3f));
    out += static_cast<char>(0x80 | (code & 0x3f));
  }
}

/// The text of a V line: Latin-1 with \uXXXX for what it lacks; nothing for rarer escapes.
std::optional<std::string> unescaped(std::string_view line) {
  std::string text;
  while (!line.empty()) {
    if (line.front() != '\\') {
      append_utf8(text, static_cast<unsigned char>(line.front()));
      line.remove_prefix(1);
      continue;
    }
    unsigned code = 0;
    if (!line.starts_with("\\u") || line.size() < 6) return std::nullopt;
    const auto [end, error] = std::from_chars(line.data() + 2, line.data() + 6, code, 16);
    if (error != std::errc{} || end != line.data() + 6) return std::nullopt;
    if (code == 0 || (code >= 0xd800 && code < 0xe000)) return std::nullopt;
    append_utf8(text, code);
    line.remove_prefix(6);
  }
  return text;
}

}  // namespace

std::optional<std::string> text_if_any(const hdf5::Object& object, const char* name) {
  const std::optional<Attribute> value = hdf5::read_attribute(object, name);
  if (!value) return std::nullopt;
  const auto* text = std::get_if<std::string>(&*value);
  return text == nullptr ? std::nullopt : std::optional(*text);
}

std::optional<std::string> matlab_class(const hdf5::Object& object) {
  return text_if_any(object, "MATLAB_class");
}

bool holds_matlab_numbers(const hdf5::Object& dataset) {
  constexpr std::array<std::string_view, 11> kNumbers = {"double", "single", "logical", "int8",
                                                         "int16",  "int32",  "int64",   "uint8",
                                                         "uint16", "uint32", "uint64"};
  return std::find(kNumbers.begin(), kNumbers.end(), matlab_class(dataset)) != kNumbers.end() &&
         !hdf5::read_attribute(dataset, "MATLAB_empty");
}

void refuse_matlab_objects(const hdf5::Object& dataset) {
  const std::optional<std::string> name = matlab_class(dataset);
  if (!name || holds_matlab_numbers(dataset)) return;
  if (hdf5::read_attribute(dataset, "MATLAB_object_decode"))
    throw InputError(fmt::format(
        "{} is a MATLAB object of class {}, which only MATLAB can read; in MATLAB turn a table t "
        "into arrays with s = table2struct(t, 'ToScalar', true) and save s with -v7.3, or use "
        "writetable(t, 'FILE.csv')",
        dataset.where, *name));
  if (hdf5::read_attribute(dataset, "MATLAB_empty"))
    throw InputError(
        fmt::format("{} is an empty MATLAB array; there is nothing to read", dataset.where));
  throw InputError(
      fmt::format("{} has the MATLAB class {}; a column of a table is an array of numbers",
                  dataset.where, *name));
}

std::optional<std::string> why_unreadable(const hdf5::Object& group) {
  const std::optional<std::string> matlab = matlab_class(group);
  if (hdf5::read_attribute(group, "MATLAB_sparse"))
    return fmt::format("{} is a sparse MATLAB array; store full(x) instead", group.where);
  if (matlab && matlab != "struct")
    return fmt::format(
        "{} has the MATLAB class {}; a table is an array of numbers or a struct of "
        "such arrays",
        group.where, *matlab);
  const std::optional<std::string> pandas = text_if_any(group, "pandas_type");
  if (pandas == "frame" || pandas == "series")
    return fmt::format(
        "{} is a pandas {} stored with format=\"fixed\"; store it with "
        "to_hdf(..., format=\"table\") or to_csv",
        group.where, *pandas);
  return std::nullopt;
}

std::vector<std::string> pandas_names(const hdf5::Object& dataset, const std::string& member) {
  const auto pickle = text_if_any(dataset, (member + "_kind").c_str());
  return pickle ? unpickled_texts(*pickle).value_or(std::vector<std::string>{})
                : std::vector<std::string>{};
}

bool is_pandas_index(const hdf5::Object& dataset, const std::string& member) {
  return member == "index" && text_if_any(dataset, "index_kind");
}

bool is_internal_path(std::string_view path) {
  return path.find("/_i_") != std::string_view::npos || path.starts_with("/#refs#") ||
         path.starts_with("/#subsystem#");
}

bool is_internal_attribute(std::string_view name) {
  constexpr std::array<std::string_view, 6> kNames = {"CLASS", "TITLE",  "VERSION",
                                                      "NROWS", "FLAVOR", "H5PATH"};
  return name.starts_with("MATLAB_") || name.starts_with("FIELD_") ||
         std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

std::optional<std::vector<std::string>> unpickled_texts(std::string_view pickle) {
  if (!pickle.starts_with("(lp0\n")) return std::nullopt;
  pickle.remove_prefix(5);
  std::vector<std::string> texts;
  while (pickle != ".") {
    const std::size_t line_end = pickle.find('\n');
    if (!pickle.starts_with('V') || line_end == std::string_view::npos) return std::nullopt;
    std::optional<std::string> text = unescaped(pickle.substr(1, line_end - 1));
    const std::size_t memo_end = pickle.find('\n', line_end + 1);
    if (!text || memo_end == std::string_view::npos || pickle[line_end + 1] != 'p' ||
        pickle.substr(memo_end + 1, 1) != "a")
      return std::nullopt;
    texts.push_back(std::move(*text));
    pickle.remove_prefix(memo_end + 2);
  }
  return texts;
}

}  // namespace repose::table
