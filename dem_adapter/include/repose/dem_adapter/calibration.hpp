// Calibration from parameters to proof: screen, sample, learn, improve, optimise, verify.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/dataset.hpp"
#include "repose/dem_adapter/study.hpp"
#include "repose/doe/screening.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::dem_adapter {

/// Where a calibration tells what it does; both may be empty.
struct CalibrationObserver {
  std::function<void(const std::string& sentence)> say;
  std::function<ProgressCallback(const std::string& label)> progress;
};

/// Surrogates of the targets' KPIs over the parameters that matter, in unit coordinates.
struct SurrogateSet {
  std::vector<std::string> parameters;
  std::vector<surrogate::GaussianProcess> models;  ///< one a target
  std::vector<double>
      r2;  ///< of left-out points: 1 - sum (mean - predicted)^2 / sum (mean - grand mean)^2
  /// What each was trained with, the runs that have a value of its KPI: runs x parameters, unit
  /// coordinates, and the values.
  std::vector<Matrix> x;
  std::vector<Vector> y;
  /// The most that one was trained with.
  int runs() const {
    Eigen::Index most = 0;
    for (const auto& rows : x) most = std::max(most, rows.rows());
    return static_cast<int>(most);
  }
};

/// One row of the history of adaptive sampling.
struct AdaptiveStep {
  int batch = 0;  ///< 0: the initial sample
  int runs = 0;   ///< that the surrogates were trained with
  std::vector<double> r2;
  double best_expected_error = 0.0;  ///< smallest expected weighted error among simulated points
};

struct CalibratedParameter {
  std::string name;
  double value = 0.0;
  bool selected = false;  ///< by the screening; the others stay at the middle of their range
  /// Range of the points whose expected error the surrogates cannot tell from the optimum's: within
  /// one standard deviation of its predicted error. Equal to value for parameters that were not
  /// selected.
  double lowest = 0.0, highest = 0.0;
  double range_share = 0.0;  ///< (highest - lowest) / declared range, on the parameter's scale
  bool is_ridge() const { return selected && range_share > 0.5; }
};

struct MeanAndDeviation {
  double mean = 0.0;
  double deviation = 0.0;  ///< sample standard deviation; 0 for one value
  int count = 0;
};

struct CalibratedKpi {
  MeasuredTarget target;
  Gaussian predicted;  ///< of the function, by the surrogate
  MeanAndDeviation verified;
  MeanAndDeviation baseline;                     ///< at the best screening point
  double lowest_seen = 0.0, highest_seen = 0.0;  ///< over all runs before verification
  bool reached() const {
    return lowest_seen <= target.target.value && target.target.value <= highest_seen;
  }
  double predicted_relative_error() const;
  double verified_relative_error() const;  ///< (verified - target)/scale
};

struct Calibration {
  doe::Screening screening;
  Matrix screening_design;  ///< coded, runs x parameters
  std::vector<AdaptiveStep> history;
  std::string stop_reason;  ///< of adaptive sampling
  SurrogateSet surrogates;
  std::vector<CalibratedParameter> parameters;
  ParameterValues values;  ///< complete, ties and fixed ones included
  std::vector<CalibratedKpi> kpis;
  double predicted_error = 0.0;  ///< expected weighted error at the optimum, by the surrogates
  double verified_error = 0.0;   ///< weighted error of the verified means
  double baseline_error = 0.0;   ///< of the best screening point, same seeds
  Vector baseline_unit;
  std::vector<std::string> remarks;  ///< sentences a reader must know: targets not reached, ridges
  Dataset data;
};

/// Runs the study in the campaign's directory, where it keeps runs.h5 up to date. Every decision
/// follows from the study and the outcomes of runs, which are kept there: the same call goes on
/// after any interruption. Throws Interrupted, Errors.
Calibration calibrate(const Study& study, const Campaign& campaign,
                      const CalibrationObserver& observer);

/// Fits one surrogate for each target to the usable runs of `data`, over `parameters`.
SurrogateSet fit_surrogates(const Study& study, const Dataset& data,
                            const std::vector<std::string>& parameters);

/// Writes result.toml, report.html, screening.h5, runs.h5 and models/ into `directory`, each
/// atomically.
void write_results(const std::filesystem::path& directory, const Study& study,
                   const Calibration& result, const std::string& command_line);

/// The tables that `repose calibrate` prints, at most 100 columns wide.
std::string plan_text(const Study& study, unsigned workers, double seconds_per_run);
std::string screening_text(const doe::Screening& screening);
std::string result_text(const Study& study, const Calibration& result);

}  // namespace repose::dem_adapter
