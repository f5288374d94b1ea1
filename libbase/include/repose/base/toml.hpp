// TOML files read strictly: every key is known, every value is checked, every error names file and
// line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace repose {

/// What a number may be; bounds are closed unless said otherwise.
struct Allowed {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool open_lower = false;
  bool open_upper = false;
  bool contains(double value) const;
  std::string text() const;  ///< "in (0, 1]", "above 0", "any finite number"
};
inline constexpr Allowed kPositive{.lower = 0.0, .open_lower = true};
inline constexpr Allowed kNonNegative{.lower = 0.0};

/// The number that an expression stands for; throws InputError that says what is wrong with it.
using EvaluateExpression = std::function<double(const std::string& expression)>;

/// A table of a TOML document. Reading a key marks it as known; refuse_unknown_keys() then reports
/// the first key of this table and of its opened sub-tables that nobody asked for. All functions
/// throw InputError as "FILE:LINE: table.key = value: what is wrong; what is allowed; what to do".
class TomlTable {
 public:
  /// Parses a file. Throws StorageError if it cannot be read, InputError if it is not TOML.
  static TomlTable read_file(const std::filesystem::path& path);
  /// Parses text; `name` stands for the file in messages.
  static TomlTable parse(std::string_view text, const std::string& name);

  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;  ///< in order of the file's lines

  double number(std::string_view key, const Allowed& allowed = {}) const;
  double number_or(std::string_view key, double fallback, const Allowed& allowed = {}) const;
  std::int64_t integer(std::string_view key, const Allowed& allowed = {}) const;
  std::int64_t integer_or(std::string_view key, std::int64_t fallback,
                          const Allowed& allowed = {}) const;
  std::string text(std::string_view key) const;
  std::string text_or(std::string_view key, std::string fallback) const;
  /// A text that must be one of `choices`.
  std::string choice(std::string_view key, const std::vector<std::string>& choices) const;
  std::string choice_or(std::string_view key, std::string fallback,
                        const std::vector<std::string>& choices) const;
  bool flag_or(std::string_view key, bool fallback) const;
  std::vector<double> numbers(std::string_view key, const Allowed& allowed = {}) const;
  std::vector<std::string> texts(std::string_view key) const;
  TomlTable table(std::string_view key) const;
  std::optional<TomlTable> table_if_present(std::string_view key) const;
  /// An array of tables, `[[key]]` or `key = [{...}, ...]`; empty if absent.
  std::vector<TomlTable> tables(std::string_view key) const;
  bool is_table(std::string_view key) const;

  /// The same table, no key of which is known yet, with expressions: wherever a number is asked
  /// for, here, in lists and in the tables opened from it, a text "= EXPRESSION" stands for what
  /// `evaluate` makes of it. Without a function it is a copy without expressions.
  TomlTable with_expressions(EvaluateExpression evaluate) const;

  /// Throws InputError about `key` of this table ("" for the table itself), with file and line.
  [[noreturn]] void fail(std::string_view key, const std::string& what) const;
  void refuse_unknown_keys() const;
  /// "FILE" of the document.
  const std::string& file() const;

 private:
  struct Node;
  explicit TomlTable(std::shared_ptr<Node> node);
  std::shared_ptr<Node> node_;
};

/// A TOML string literal of `text`, quoted and escaped.
std::string toml_quoted(std::string_view text);

}  // namespace repose
