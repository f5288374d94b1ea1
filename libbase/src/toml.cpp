#include "repose/base/toml.hpp"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose {
namespace {

constexpr double kLargestWhole = 9007199254740992.0;  // 2^53: all whole numbers up to it are exact

}  // namespace

struct TomlTable::Node {
  std::shared_ptr<const toml::table> document;  // keeps `table` alive
  const toml::table* table = nullptr;
  std::string file;
  std::string path;  // dotted name of this table, "" for the document
  std::set<std::string, std::less<>> known;
  std::vector<std::shared_ptr<Node>> opened;
  std::shared_ptr<const EvaluateExpression> evaluate;  // null where expressions mean nothing

  std::string name_of(std::string_view key) const {
    if (key.empty()) return path;
    return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
  }
  [[noreturn]] void fail(std::string_view key, const std::string& what) const {
    const toml::node* node = key.empty() ? nullptr : table->get(key);
    const auto line = (node != nullptr ? node->source() : table->source()).begin.line;
    const std::string name = name_of(key);
    throw InputError(fmt::format("{}:{}: {}{}{}", file, std::max<unsigned>(1, line), name,
                                 name.empty() ? "" : ": ", what));
  }
  const toml::node& get(std::string_view key) {
    known.emplace(key);
    const toml::node* node = table->get(key);
    if (node == nullptr) {
      std::vector<std::string> present;
      for (const auto& [k, v] : *table) present.emplace_back(k.str());
      const std::string similar = closest_name(key, present);
      fail("", fmt::format("the key {} is missing{}; add it", key,
                           similar.empty() ? "" : fmt::format(" (there is {})", similar)));
    }
    return *node;
  }
  /// "= a + b" where expressions mean something, else empty.
  std::string expression_of(const toml::node& node) const {
    if (evaluate == nullptr || !node.is_string()) return "";
    auto text = *node.value<std::string>();
    return text.starts_with("=") ? text : "";
  }
  double value_of(const toml::node& node, std::string_view key,
                  const std::string& expression) const {
    if (expression.empty()) {
      if (!node.is_number())
        fail(key, evaluate == nullptr ? "must be a number"
                                      : "must be a number or an expression, \"= ...\"");
      return *node.value<double>();
    }
    try {
      return (*evaluate)(expression.substr(1));
    } catch (const InputError& error) {
      fail(key, fmt::format("\"{}\": {}", expression, error.what()));
    }
  }
  double as_number(const toml::node& node, std::string_view key, const Allowed& allowed) const {
    const std::string expression = expression_of(node);
    const double value = value_of(node, key, expression);
    const std::string given = expression.empty()
                                  ? shortest(value)
                                  : fmt::format("\"{}\" = {}", expression, shortest(value));
    if (!std::isfinite(value))
      fail(key, fmt::format("{} is not finite; give a finite number", given));
    if (!allowed.contains(value))
      fail(key, fmt::format("{} is not allowed; it must be {}", given, allowed.text()));
    return value;
  }
  std::shared_ptr<Node> open(const toml::table& child, std::string child_path) {
    auto node = std::make_shared<Node>();
    node->document = document;
    node->table = &child;
    node->file = file;
    node->path = std::move(child_path);
    node->evaluate = evaluate;
    opened.push_back(node);
    return node;
  }
  void refuse_unknown_keys() const {
    for (const auto& [key, value] : *table)
      if (known.count(key.str()) == 0) {
        std::vector<std::string> candidates(known.begin(), known.end());
        const std::string similar = closest_name(key.str(), candidates);
        fail(key.str(), similar.empty()
                            ? fmt::format("unknown key; known here: {}",
                                          candidates.empty() ? "none" : listed(candidates))
                            : fmt::format("unknown key; did you mean {}?", similar));
      }
    for (const auto& child : opened) child->refuse_unknown_keys();
  }
};

bool Allowed::contains(double value) const {
  return (open_lower ? value > lower : value >= lower) &&
         (open_upper ? value < upper : value <= upper);
}

std::string Allowed::text() const {
  const bool low = std::isfinite(lower), high = std::isfinite(upper);
  if (low && high)
    return fmt::format("in {}{}, {}{}", open_lower ? "(" : "[", shortest(lower), shortest(upper),
                       open_upper ? ")" : "]");
  if (low) return fmt::format("{} {}", open_lower ? "above" : "at least", shortest(lower));
  if (high) return fmt::format("{} {}", open_upper ? "below" : "at most", shortest(upper));
  return "any finite number";
}

TomlTable::TomlTable(std::shared_ptr<Node> node) : node_(std::move(node)) {}

TomlTable TomlTable::read_file(const std::filesystem::path& path) {
  return parse(repose::read_file(path), path.string());
}

TomlTable TomlTable::parse(std::string_view text, const std::string& name) {
  auto node = std::make_shared<Node>();
  try {
    auto document = std::make_shared<toml::table>(toml::parse(text, name));
    node->table = document.get();
    node->document = std::move(document);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: not valid TOML: {}", name, error.source().begin.line,
                                 error.description()));
  }
  node->file = name;
  return TomlTable(std::move(node));
}

bool TomlTable::has(std::string_view key) const {
  node_->known.emplace(key);
  return node_->table->contains(key);
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> found;
  for (const auto& [key, value] : *node_->table) found.emplace_back(key.source().begin, key.str());
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [position, name] : found) names.push_back(std::move(name));
  return names;
}

double TomlTable::number(std::string_view key, const Allowed& allowed) const {
  return node_->as_number(node_->get(key), key, allowed);
}

double TomlTable::number_or(std::string_view key, double fallback, const Allowed& allowed) const {
  return has(key) ? number(key, allowed) : fallback;
}

std::int64_t TomlTable::integer(std::string_view key, const Allowed& allowed) const {
  const auto& node = node_->get(key);
  if (node_->expression_of(node).empty()) {
    if (!node.is_integer()) node_->fail(key, "must be a whole number");
    node_->as_number(node, key, allowed);
    return *node.value<std::int64_t>();
  }
  const double value = node_->as_number(node, key, allowed);
  if (value != std::floor(value) || std::abs(value) > kLargestWhole)
    node_->fail(key, fmt::format("\"{}\" = {} must be a whole number; round it, e.g. with rint()",
                                 node_->expression_of(node), shortest(value)));
  return static_cast<std::int64_t>(value);
}

std::int64_t TomlTable::integer_or(std::string_view key, std::int64_t fallback,
                                   const Allowed& allowed) const {
  return has(key) ? integer(key, allowed) : fallback;
}

std::string TomlTable::text(std::string_view key) const {
  const auto& node = node_->get(key);
  if (!node.is_string()) node_->fail(key, "must be a text in quotes");
  return *node.value<std::string>();
}

std::string TomlTable::text_or(std::string_view key, std::string fallback) const {
  return has(key) ? text(key) : std::move(fallback);
}

std::string TomlTable::choice(std::string_view key, const std::vector<std::string>& choices) const {
  auto value = text(key);
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    fail(key, fmt::format("\"{}\" is not allowed; choose one of {}", value, listed(choices)));
  return value;
}

std::string TomlTable::choice_or(std::string_view key, std::string fallback,
                                 const std::vector<std::string>& choices) const {
  return has(key) ? choice(key, choices) : std::move(fallback);
}

bool TomlTable::flag_or(std::string_view key, bool fallback) const {
  if (!has(key)) return fallback;
  const auto& node = node_->get(key);
  if (!node.is_boolean()) node_->fail(key, "must be true or false");
  return *node.value<bool>();
}

std::vector<double> TomlTable::numbers(std::string_view key, const Allowed& allowed) const {
  const auto* array = node_->get(key).as_array();
  if (array == nullptr) node_->fail(key, "must be a list of numbers");
  std::vector<double> values;
  for (const auto& element : *array) values.push_back(node_->as_number(element, key, allowed));
  return values;
}

std::vector<std::string> TomlTable::texts(std::string_view key) const {
  const auto* array = node_->get(key).as_array();
  if (array == nullptr) node_->fail(key, "must be a list of texts");
  std::vector<std::string> values;
  for (const auto& element : *array) {
    if (!element.is_string()) node_->fail(key, "must be a list of texts in quotes");
    values.push_back(*element.value<std::string>());
  }
  return values;
}

TomlTable TomlTable::table(std::string_view key) const {
  const auto* table = node_->get(key).as_table();
  if (table == nullptr) node_->fail(key, "must be a table");
  return TomlTable(node_->open(*table, node_->name_of(key)));
}

std::optional<TomlTable> TomlTable::table_if_present(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return table(key);
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  std::vector<TomlTable> result;
  if (!has(key)) return result;
  const auto* array = node_->get(key).as_array();
  if (array == nullptr) node_->fail(key, "must be a list of tables");
  for (std::size_t i = 0; i < array->size(); ++i) {
    const auto* table = (*array)[i].as_table();
    if (table == nullptr) node_->fail(key, "must be a list of tables");
    result.push_back(
        TomlTable(node_->open(*table, fmt::format("{}[{}]", node_->name_of(key), i + 1))));
  }
  return result;
}

bool TomlTable::is_table(std::string_view key) const {
  return has(key) && node_->table->get(key)->is_table();
}

TomlTable TomlTable::with_expressions(EvaluateExpression evaluate) const {
  auto node = std::make_shared<Node>();
  node->document = node_->document;
  node->table = node_->table;
  node->file = node_->file;
  node->path = node_->path;
  if (evaluate) node->evaluate = std::make_shared<const EvaluateExpression>(std::move(evaluate));
  return TomlTable(std::move(node));
}

void TomlTable::fail(std::string_view key, const std::string& what) const {
  node_->fail(key, what);
}

void TomlTable::refuse_unknown_keys() const {
  node_->refuse_unknown_keys();
}

const std::string& TomlTable::file() const {
  return node_->file;
}

std::string toml_quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      quoted += fmt::format("\\{}", c);
    else if (static_cast<unsigned char>(c) < 0x20)
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    else
      quoted += c;
  }
  return quoted + '"';
}

}  // namespace repose
