// A run's outcome as JSON, for outcome.json and a line of the index.
#pragma once

#include <string>
#include <string_view>

#include "repose/dem_adapter/run_store.hpp"

namespace repose::dem_adapter {

/// One line. A message of an engine may hold bytes that are not UTF-8; they are replaced.
std::string outcome_line(const RunOutcome& outcome);
/// The same for people to read.
std::string outcome_text(const RunOutcome& outcome);
/// The line that takes a run out of the index.
std::string forgotten_line(const std::string& key);

/// Throws nlohmann::json::exception or InputError if the text is not an outcome.
RunOutcome parse_outcome(std::string_view text);

/// What the first bytes of a line of the index say, without parsing the rest.
struct LineHead {
  std::string key;
  bool is_forgotten = false;
};
/// Empty for a line that is torn or not ours.
LineHead head_of(std::string_view line);

/// Parts of a run that was stopped and will go on.
std::string resources_text(const Resources& resources);
Resources parse_resources(std::string_view text);

}  // namespace repose::dem_adapter
