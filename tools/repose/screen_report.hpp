// A screening as the commands tell it: for people, for machines and as figures.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "repose/doe/screening.hpp"

namespace repose::cli {

/// A screening with what it was made of.
struct ScreeningReport {
  std::string table;
  std::vector<std::string> repetitions;  ///< their labels
  Matrix coded;                          ///< runs x factors
  std::vector<Matrix> values;            ///< of each response, runs x repetitions
  doe::ScreeningOptions options;
  doe::Screening screening;

  /// Whether the factor reached the vote for this response.
  bool is_selected(const doe::ResponseScreening& response, std::size_t factor) const;
};

/// Tables of at most 100 columns.
std::string screening_text(const ScreeningReport& report);
nlohmann::json screening_json(const ScreeningReport& report);
/// The fields of a decomposition as the commands name them.
nlohmann::json variance_json(const doe::VarianceDecomposition& variance);

/// half_normal_RESPONSE.svg and main_effects_RESPONSE.svg of every response in `directory`, which
/// is made if need be. Returns the files. Throws StorageError.
std::vector<std::filesystem::path> write_screening_plots(const ScreeningReport& report,
                                                         const std::filesystem::path& directory);

}  // namespace repose::cli
