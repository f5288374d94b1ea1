// Every key of a case file: unit, default and meaning.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace repose::scene {

struct CaseKey {
  std::string_view table;  ///< as it is headed in the file, e.g. "[run]" or "[[wall]]"; "" at top
  std::string_view key;
  std::string_view unit;     ///< SI; "1" without dimension, "text", "true|false", "list"
  std::string_view initial;  ///< what holds if the key is absent; "" if it must be given
  std::string_view meaning;
};

/// All keys, table by table in the order of a case file. read_case() knows no others.
const std::vector<CaseKey>& case_keys();

/// The keys as text of at most `columns` columns, for --help.
std::string case_keys_text(std::size_t columns = 100);

}  // namespace repose::scene
