// A screening as the commands tell it: for people, for machines and as figures.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "repose/doe/anova.hpp"
#include "repose/doe/screening.hpp"
#include "repose/doe/target_coverage.hpp"

namespace repose::cli {

/// A screening with what it was made of.
struct ScreeningReport {
  std::string table;
  std::vector<std::string> repetitions;  ///< their labels
  Matrix coded;                          ///< runs x factors
  std::vector<Matrix> values;            ///< of each response, runs x repetitions
  std::vector<int> blocks;               ///< of the runs; empty without
  std::vector<Parameter> screened;       ///< the factors' ranges
  doe::ScreeningOptions options;
  std::optional<doe::SumsOfSquares> anova;  ///< of the final models, to be shown
  doe::Screening screening;
  std::optional<doe::TargetCoverage> coverage;

  /// Whether the factor reached the vote for this response.
  bool is_selected(const doe::ResponseScreening& response, std::size_t factor) const;
};

/// Tables of at most 100 columns.
std::string screening_text(const ScreeningReport& report);
nlohmann::json screening_json(const ScreeningReport& report);
/// Which targets the runs enclose, and the ranges proposed for those they do not.
std::string coverage_text(const ScreeningReport& report);
nlohmann::json coverage_json(const ScreeningReport& report);
/// The proposed ranges as a factors file.
std::string factors_toml(const ScreeningReport& report);
/// Analysis of variance of one repetition's final model.
std::vector<doe::AnovaRow> final_anova(const ScreeningReport& report, std::size_t response,
                                       std::size_t repetition, doe::SumsOfSquares type);
/// "-" for NaN.
std::string p_text(double p);
std::string number_text(double value);
std::string percent_text(double share, int digits);
/// Long names lose their middle.
std::string clipped(const std::string& name);
/// Lines of at most 100 columns, indented, with a line end.
std::string wrapped(const std::string& text, std::size_t indent);
std::vector<std::string> selected_names(const doe::Screening& screening);
/// The fields of a decomposition as the commands name them.
nlohmann::json variance_json(const doe::VarianceDecomposition& variance);

/// half_normal_RESPONSE.svg and main_effects_RESPONSE.svg of every response in `directory`, which
/// is made if need be. Returns the files. Throws StorageError.
std::vector<std::filesystem::path> write_screening_plots(const ScreeningReport& report,
                                                         const std::filesystem::path& directory);

}  // namespace repose::cli
