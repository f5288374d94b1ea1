#include "repose/dem_adapter/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::finished:
      return "finished";
    case Outcome::kpi_undefined:
      return "kpi-undefined";
    case Outcome::nothing_flowed:
      return "nothing-flowed";
    case Outcome::jammed_outlet:
      return "jammed-outlet";
    case Outcome::particles_lost:
      return "particles-lost";
    case Outcome::non_finite:
      return "non-finite";
    case Outcome::unphysical:
      return "unphysical";
    case Outcome::time_limit:
      return "time-limit";
    case Outcome::crash:
      return "crash";
    case Outcome::killed:
      return "killed";
    case Outcome::engine_failed:
      return "engine-failed";
    case Outcome::output_unreadable:
      return "output-unreadable";
  }
  return "?";
}

const std::vector<Outcome>& all_outcomes() {
  static const std::vector<Outcome> kAll{
      Outcome::finished,      Outcome::kpi_undefined,  Outcome::nothing_flowed,
      Outcome::jammed_outlet, Outcome::particles_lost, Outcome::non_finite,
      Outcome::unphysical,    Outcome::time_limit,     Outcome::crash,
      Outcome::killed,        Outcome::engine_failed,  Outcome::output_unreadable};
  return kAll;
}

Outcome outcome_named(std::string_view name) {
  std::vector<std::string> names;
  for (const Outcome outcome : all_outcomes()) {
    if (name == to_string(outcome)) return outcome;
    names.emplace_back(to_string(outcome));
  }
  throw InputError(fmt::format("\"{}\" is no outcome of a run; there are {}", name, listed(names)));
}

bool is_failure(Outcome outcome) {
  return outcome != Outcome::finished && outcome != Outcome::kpi_undefined;
}

Resources& Resources::operator+=(const Resources& later) {
  wall_time_s += later.wall_time_s;
  cpu_time_s += later.cpu_time_s;
  peak_memory_bytes = std::max(peak_memory_bytes, later.peak_memory_bytes);
  ranks = later.ranks;
  parts += later.parts;
  return *this;
}

}  // namespace repose::dem_adapter
