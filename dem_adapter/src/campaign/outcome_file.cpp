#include "outcome_file.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"

namespace repose::dem_adapter {

std::optional<RunOutcome> read_outcome(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(read_file(file));
    RunOutcome outcome;
    outcome.key = file.parent_path().filename().string();
    outcome.wall_time_s = json.at("wall_time_s").get<double>();
    outcome.exceeded_limit_s = json.at("exceeded_limit_s").get<double>();
    auto& m = outcome.measurement;
    m.failure = json.at("failure").get<std::string>();
    m.kpis = json.at("kpis").get<std::map<std::string, double>>();
    m.details = json.at("details").get<std::map<std::string, double>>();
    m.warnings = json.at("warnings").get<std::vector<std::string>>();
    return outcome;
  } catch (const nlohmann::json::exception& error) {
    throw StorageError(
        fmt::format("'{}' is damaged ({}); remove that file to have the run done again",
                    file.string(), error.what()));
  }
}

void write_outcome(const std::filesystem::path& file, const RunOutcome& outcome,
                   const std::string& engine) {
  const auto& m = outcome.measurement;
  const nlohmann::json json{{"status", m.failure.empty() ? "finished" : "failed"},
                            {"failure", m.failure},
                            {"kpis", m.kpis},
                            {"details", m.details},
                            {"warnings", m.warnings},
                            {"engine", engine},
                            {"wall_time_s", outcome.wall_time_s},
                            {"exceeded_limit_s", outcome.exceeded_limit_s}};
  // A message of the engine may hold bytes that are not UTF-8; they are replaced, not refused.
  write_file_atomically(file,
                        json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace repose::dem_adapter
