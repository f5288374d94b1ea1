#include "outcome_json.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

namespace repose::dem_adapter {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::string_view kRun = R"({"run":")", kForgotten = R"({"forgotten":")";
constexpr std::size_t kKeyDigits = 16;

Json as_json(const Resources& r) {
  return {{"wall_time_s", r.wall_time_s},
          {"cpu_time_s", r.cpu_time_s},
          {"peak_memory_bytes", r.peak_memory_bytes},
          {"ranks", r.ranks},
          {"parts", r.parts}};
}

Resources resources_from(const Json& json) {
  return {.wall_time_s = json.at("wall_time_s").get<double>(),
          .cpu_time_s = json.at("cpu_time_s").get<double>(),
          .peak_memory_bytes = json.at("peak_memory_bytes").get<std::int64_t>(),
          .ranks = json.at("ranks").get<int>(),
          .parts = json.at("parts").get<int>()};
}

Json as_json(const RunOutcome& outcome) {
  const auto& m = outcome.measurement;
  return {{"run", outcome.key},
          {"outcome", to_string(m.outcome)},
          {"failure", m.failure},
          {"seed", outcome.seed},
          {"kpis", m.kpis},
          {"details", m.details},
          {"warnings", m.warnings},
          {"engine", outcome.engine},
          {"measured_by", outcome.measured_by},
          {"resources", as_json(outcome.resources)},
          {"exceeded_limit_s", outcome.exceeded_limit_s}};
}

std::string dumped(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string outcome_line(const RunOutcome& outcome) {
  return dumped(as_json(outcome), -1);
}

std::string outcome_text(const RunOutcome& outcome) {
  return dumped(as_json(outcome), 2) + "\n";
}

std::string forgotten_line(const std::string& key) {
  return std::string(kForgotten) + key + "\"}";
}

RunOutcome parse_outcome(std::string_view text) {
  const auto json = Json::parse(text);
  RunOutcome outcome;
  outcome.key = json.at("run").get<std::string>();
  outcome.seed = json.at("seed").get<std::uint64_t>();
  outcome.engine = json.at("engine").get<std::string>();
  outcome.measured_by = json.at("measured_by").get<std::string>();
  outcome.resources = resources_from(json.at("resources"));
  outcome.exceeded_limit_s = json.at("exceeded_limit_s").get<double>();
  auto& m = outcome.measurement;
  m.outcome = outcome_named(json.at("outcome").get<std::string>());
  m.failure = json.at("failure").get<std::string>();
  m.kpis = json.at("kpis").get<std::map<std::string, double>>();
  m.details = json.at("details").get<std::map<std::string, double>>();
  m.warnings = json.at("warnings").get<std::vector<std::string>>();
  return outcome;
}

LineHead head_of(std::string_view line) {
  if (line.empty() || line.back() != '}') return {};
  const bool is_forgotten = line.starts_with(kForgotten);
  if (!is_forgotten && !line.starts_with(kRun)) return {};
  const auto key = line.substr((is_forgotten ? kForgotten : kRun).size());
  if (key.size() <= kKeyDigits || key[kKeyDigits] != '"') return {};
  const auto digits = key.substr(0, kKeyDigits);
  if (!std::all_of(digits.begin(), digits.end(),
                   [](unsigned char c) { return std::isxdigit(c) != 0; }))
    return {};
  return {.key = std::string(digits), .is_forgotten = is_forgotten};
}

std::string resources_text(const Resources& resources) {
  return dumped(as_json(resources), 2) + "\n";
}

Resources parse_resources(std::string_view text) {
  return resources_from(Json::parse(text));
}

}  // namespace repose::dem_adapter
