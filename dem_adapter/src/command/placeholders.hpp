// Placeholders ${name} in a user's templates and commands.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace repose::dem_adapter {

/// A placeholder and where it stands.
struct Placeholder {
  std::string name;
  std::size_t line = 1;
};

/// All placeholders of a text, in its order: ${name}, a name being letters, digits and _ that do
/// not begin with a digit. `$${` stands for a plain `${`. Throws InputError with the line if "${"
/// is followed by anything else.
std::vector<Placeholder> placeholders_of(std::string_view text);

/// The text with each placeholder replaced by its value and `$${` by `${`. Every name must have a
/// value.
std::string filled_in(std::string_view text, const std::map<std::string, std::string>& values);

}  // namespace repose::dem_adapter
