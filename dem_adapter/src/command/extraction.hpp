// One number out of what a user's command left behind.
#pragma once

#include <filesystem>
#include <regex>
#include <string>
#include <variant>

#include "repose/base/toml.hpp"
#include "repose/dem_adapter/view.hpp"
#include "repose/dem_adapter/view_angle.hpp"

namespace repose::dem_adapter {

/// A number of a JSON file, by JSON pointer (RFC 6901), e.g. "/kpis/angle". null: undefined.
struct JsonNumber {
  std::string pointer;
};

/// Of a column of a table (CSV, or FILE.h5:/group); a missing value is undefined.
enum class RowChoice { only, first, last, mean, least, most };
struct ColumnNumber {
  std::string column;
  RowChoice row = RowChoice::only;
};

/// Of a text, line by line, by an ECMAScript regular expression.
enum class MatchChoice { only, first, last };
struct TextNumber {
  std::string pattern;
  std::regex compiled;
  unsigned group = 1;
  MatchChoice match = MatchChoice::only;
};

/// The angle of the edge of particles: a table with x_m, y_m, z_m, radius_m and, where there,
/// material (names) and vx_m_s, vy_m_s, vz_m_s. Too few columns in the edge: undefined.
struct ParticleAngle {
  EdgeOptions edge;
  ParticleViewOptions view;
};

struct Extraction {
  std::string file;  ///< in the folder where the command ran; empty: what the command said
  std::variant<JsonNumber, ColumnNumber, TextNumber, ParticleAngle> number;
  std::string definition;  ///< all of its keys: two that differ may give different numbers
};

/// Reads the keys `file` and those of one kind: pointer | column, row | pattern, group, match |
/// shape, view, axis_m, floor_m, toe_m, outlet_m, from, to, fit. Throws InputError with file and
/// line.
Extraction read_extraction(const TomlTable& table);

/// The number, NaN if it is undefined. Throws InputError or StorageError if the file is missing or
/// damaged, or if the number is not there or there more than once.
double extracted(const Extraction& extraction, const std::filesystem::path& folder,
                 const std::filesystem::path& log);

}  // namespace repose::dem_adapter
