#include "extraction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kLongestLine = 4000;  // the library's matcher recurses once a character

template <class Value>
using Choices = std::map<std::string, Value>;

template <class Value>
Value choice(const TomlTable& table, const char* key, const char* initial,
             const Choices<Value>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  return choices.at(table.choice_or(key, initial, names));
}

JsonNumber read_json(const TomlTable& table) {
  JsonNumber number{table.text("pointer")};
  try {
    static_cast<void>(nlohmann::json::json_pointer(number.pointer));
  } catch (const nlohmann::json::exception&) {
    table.fail("pointer", "this is no JSON pointer; write e.g. \"/kpis/angle\"");
  }
  return number;
}

ColumnNumber read_column(const TomlTable& table) {
  return {.column = table.text("column"),
          .row = choice<RowChoice>(table, "row", "only",
                                   {{"only", RowChoice::only},
                                    {"first", RowChoice::first},
                                    {"last", RowChoice::last},
                                    {"mean", RowChoice::mean},
                                    {"min", RowChoice::least},
                                    {"max", RowChoice::most}})};
}

TextNumber read_pattern(const TomlTable& table) {
  TextNumber number{
      .pattern = table.text("pattern"),
      .compiled = {},
      .group = static_cast<unsigned>(table.integer_or("group", 1, {.lower = 0, .upper = 1000})),
      .match = choice<MatchChoice>(table, "match", "only",
                                   {{"only", MatchChoice::only},
                                    {"first", MatchChoice::first},
                                    {"last", MatchChoice::last}})};
  try {
    number.compiled.assign(number.pattern, std::regex::ECMAScript);
  } catch (const std::regex_error& error) {
    table.fail("pattern", fmt::format("this is no regular expression: {}", error.what()));
  }
  if (number.group > number.compiled.mark_count())
    table.fail("group", fmt::format("the pattern has {} groups in parentheses; put one around the "
                                    "number",
                                    number.compiled.mark_count()));
  return number;
}

ParticleAngle read_angle(const TomlTable& table) {
  ParticleAngle angle;
  EdgeOptions& edge = angle.edge;
  edge.shape = choice<EdgeShape>(table, "shape", "heap",
                                 {{"heap", EdgeShape::heap}, {"slopes", EdgeShape::slopes}});
  edge.fit =
      choice<LineFit>(table, "fit", "robust",
                      {{"robust", LineFit::robust}, {"least-squares", LineFit::least_squares}});
  angle.view.direction =
      choice<ViewDirection>(table, "view", "front",
                            {{"front", ViewDirection::along_y}, {"side", ViewDirection::along_x}});
  if (table.has("floor_m")) edge.floor_m = table.number("floor_m");
  if (edge.shape == EdgeShape::heap) {  // the keys of a heap; for slopes they are unknown
    if (table.has("axis_m")) edge.axis_m = table.number("axis_m");
    if (table.has("toe_m")) edge.toe_m = table.number("toe_m", kNonNegative);
    edge.from = table.number_or("from", 0.0, {.lower = 0.0, .upper = 1.0});
    edge.to = table.number_or("to", 1.0, {.lower = edge.from, .upper = 1.0, .open_lower = true});
  }
  if (edge.shape == EdgeShape::slopes) {
    const auto outlet = table.numbers("outlet_m");
    if (outlet.size() != 2 || !(outlet[0] < outlet[1]))
      table.fail("outlet_m", "give its left and its right end, [x, x]");
    edge.outlet_m = std::pair(outlet[0], outlet[1]);
  }
  return angle;
}

std::string read_file_name(const TomlTable& table) {
  if (!table.has("file")) return "";
  const auto file = table.text("file");
  const std::filesystem::path normal = std::filesystem::path(file).lexically_normal();
  if (file.empty() || normal.is_absolute() || *normal.begin() == "..")
    table.fail("file", "it must lie in the folder where the command runs; give a relative path");
  return file;
}

/// All keys with their values, for a name.
std::string definition_of(const Extraction& e) {
  std::string text = fmt::format("file={};", e.file);
  const auto optional = [](const std::optional<double>& x) { return x ? shortest(*x) : "-"; };
  if (const auto* json = std::get_if<JsonNumber>(&e.number)) {
    text += "pointer=" + json->pointer;
  } else if (const auto* column = std::get_if<ColumnNumber>(&e.number)) {
    text += fmt::format("column={};row={}", column->column, static_cast<int>(column->row));
  } else if (const auto* match = std::get_if<TextNumber>(&e.number)) {
    text += fmt::format("pattern={};group={};match={}", match->pattern, match->group,
                        static_cast<int>(match->match));
  } else {
    const auto& [edge, view] = std::get<ParticleAngle>(e.number);
    text +=
        fmt::format("shape={};fit={};view={};axis={};floor={};toe={};from={};to={}",
                    static_cast<int>(edge.shape), static_cast<int>(edge.fit),
                    static_cast<int>(view.direction), optional(edge.axis_m), optional(edge.floor_m),
                    optional(edge.toe_m), shortest(edge.from), shortest(edge.to));
    if (edge.outlet_m)
      text += fmt::format(";outlet={},{}", shortest(edge.outlet_m->first),
                          shortest(edge.outlet_m->second));
  }
  return text;
}

/// The whole text as a number; spaces around it do not count.
double number_of(std::string text, const std::string& where) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_space(text.back())) text.pop_back();
  std::size_t begin = 0;
  while (begin < text.size() && is_space(text[begin])) ++begin;
  if (begin < text.size() && text[begin] == '+') ++begin;
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data() + begin, end, value);
  if (code != std::errc{} || stop != end)
    throw InputError(fmt::format("{}: \"{}\" is not a number", where, text));
  return value;
}

double json_number(const JsonNumber& number, const std::string& name, const std::string& text) {
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{} is not JSON: {}; where there is no value write null, not NaN",
                                 name, error.what()));
  }
  const nlohmann::json::json_pointer pointer(number.pointer);
  bool is_there = false;
  try {
    is_there = json.contains(pointer);
  } catch (const nlohmann::json::exception&) {  // an index into an array that is none
  }
  if (!is_there) throw InputError(fmt::format("{} has no {}", name, number.pointer));
  const auto& value = json.at(pointer);
  if (value.is_null()) return kUndefined;
  if (!value.is_number())
    throw InputError(fmt::format("{}: {} is {}, not a number", name, number.pointer,
                                 value.is_string() ? "a text" : value.type_name()));
  return value.get<double>();
}

double column_number(const ColumnNumber& number, const std::filesystem::path& location) {
  const auto name = location.filename().string();
  const auto table =
      table::read_table(table::parse_location(location.string()), table::Missing::allow);
  const auto values = table.numbers(number.column);
  if (values.empty()) throw InputError(fmt::format("{} has no rows", name));
  switch (number.row) {
    case RowChoice::only:
      if (values.size() > 1)
        throw InputError(
            fmt::format("{} has {} rows; choose one with row = \"first\", \"last\", \"mean\", "
                        "\"min\" or \"max\"",
                        name, values.size()));
      return values.front();
    case RowChoice::first:
      return values.front();
    case RowChoice::last:
      return values.back();
    case RowChoice::mean:
      return std::accumulate(values.begin(), values.end(), 0.0) /
             static_cast<double>(values.size());
    case RowChoice::least:
    case RowChoice::most:
      if (std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); }))
        return kUndefined;
      return number.row == RowChoice::least ? *std::min_element(values.begin(), values.end())
                                            : *std::max_element(values.begin(), values.end());
  }
  return kUndefined;
}

double text_number(const TextNumber& number, const std::string& name, const std::string& text) {
  std::istringstream lines(text);
  std::string found;
  std::size_t count = 0, at = 0, in_line = 0;
  for (std::string line; std::getline(lines, line);) {
    ++in_line;
    if (line.size() > kLongestLine)
      throw InputError(
          fmt::format("line {} of {} has {} bytes; a pattern is looked for in lines of at most {}",
                      in_line, name, line.size(), kLongestLine));
    for (std::sregex_iterator match(line.begin(), line.end(), number.compiled), none; match != none;
         ++match) {
      ++count;
      if (number.match == MatchChoice::first && count > 1) break;
      found = (*match)[number.group].str();
      at = in_line;
    }
  }
  if (count == 0)
    throw InputError(fmt::format("{} has nothing that matches {}", name, number.pattern));
  if (count > 1 && number.match == MatchChoice::only)
    throw InputError(
        fmt::format("{} has {} places that match {}; choose one with match = \"first\" or "
                    "\"last\"",
                    name, count, number.pattern));
  return number_of(found, fmt::format("{}, line {}", name, at));
}

/// Spheres of a table; all at rest where it has no velocities.
scene::Snapshot snapshot_of(const table::Table& table) {
  scene::Snapshot s;
  const auto vectors = [&](const std::string& prefix, const std::string& suffix) {
    std::vector<scene::Vec3> result(table.rows(), scene::Vec3::Zero());
    const char* const axes[3] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
      const auto values = table.numbers(prefix + axes[k] + suffix);
      for (std::size_t i = 0; i < result.size(); ++i) result[i][k] = values[i];
    }
    return result;
  };
  s.position = vectors("", "_m");
  s.velocity = table.has("vx_m_s") ? vectors("v", "_m_s")
                                   : std::vector<scene::Vec3>(table.rows(), scene::Vec3::Zero());
  s.radius_m = table.numbers("radius_m");
  s.angular_velocity.assign(table.rows(), scene::Vec3::Zero());
  s.mass_kg.assign(table.rows(), 0.0);
  s.material.assign(table.rows(), 0);
  s.materials = {"particles"};
  if (table.has("material") &&
      std::holds_alternative<std::vector<std::string>>(table.column("material").values)) {
    s.materials.clear();
    std::map<std::string, std::int64_t> index;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const auto& material = table.texts("material")[i];
      const auto [place, is_new] =
          index.emplace(material, static_cast<std::int64_t>(s.materials.size()));
      if (is_new) s.materials.push_back(material);
      s.material[i] = place->second;
    }
  }
  for (std::size_t i = 0; i < table.rows(); ++i) {
    s.id.push_back(static_cast<std::int64_t>(i));
    s.body.push_back(static_cast<std::int64_t>(i));
  }
  return s;
}

double particle_angle(const ParticleAngle& angle, const std::filesystem::path& location) {
  const auto snapshot = snapshot_of(table::read_table(table::parse_location(location.string())));
  try {
    return measure_angle(view_of_particles(snapshot, angle.view), angle.edge).angles.mean_deg();
  } catch (const InputError&) {  // nothing is seen, or too little for an edge
    return kUndefined;
  }
}

}  // namespace

Extraction read_extraction(const TomlTable& table) {
  const char* const kinds[] = {"pointer", "column", "pattern", "shape"};
  std::string kind;
  for (const char* key : kinds) {
    if (!table.has(key)) continue;
    if (!kind.empty())
      table.fail(key, fmt::format("there is {} already; a number is taken in one way", kind));
    kind = key;
  }
  Extraction extraction;
  extraction.file = read_file_name(table);
  if (kind == "pointer")
    extraction.number = read_json(table);
  else if (kind == "column")
    extraction.number = read_column(table);
  else if (kind == "pattern")
    extraction.number = read_pattern(table);
  else if (kind == "shape")
    extraction.number = read_angle(table);
  else
    table.fail("",
               "say how the number is found: pointer (JSON), column (CSV or HDF5), pattern "
               "(regular expression) or shape (angle of particles)");
  if (extraction.file.empty() && kind != "pattern")
    table.fail("", fmt::format("the key file is missing; {} needs one", kind));
  extraction.definition = definition_of(extraction);
  return extraction;
}

double extracted(const Extraction& extraction, const std::filesystem::path& folder,
                 const std::filesystem::path& log) {
  const auto path = extraction.file.empty() ? log : folder / extraction.file;
  const auto name = extraction.file.empty() ? "what the command said" : extraction.file;
  const auto on_disk = table::parse_location(path.string()).file;
  if (!std::filesystem::is_regular_file(on_disk))
    throw InputError(fmt::format("the command left no file {}", name));
  if (const auto* number = std::get_if<JsonNumber>(&extraction.number))
    return json_number(*number, name, read_file(path));
  if (const auto* number = std::get_if<ColumnNumber>(&extraction.number))
    return column_number(*number, path);
  if (const auto* number = std::get_if<TextNumber>(&extraction.number))
    return text_number(*number, name, read_file(path));
  return particle_angle(std::get<ParticleAngle>(extraction.number), path);
}

}  // namespace repose::dem_adapter
