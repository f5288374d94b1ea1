// The steps of a calibration, each a function of what is known before it.
#pragma once

#include <string>
#include <vector>

#include "repose/dem_adapter/calibration.hpp"

namespace repose::dem_adapter {

/// The screening design in coded units for all free parameters of the study.
Matrix screening_design(const Study& study);

/// Analyses the screening runs of `data`; failed runs are missing values, and a repetition that
/// lost too many is left out with a remark. Throws SimulationError if none is left.
doe::Screening analyse_screening(const Study& study, const Matrix& coded, const Dataset& data,
                                 std::vector<std::string>& remarks);

/// Why the runs of a dataset failed, commonest reason first, for the message of an error.
std::string failure_summary(const Dataset& data);

/// Names of the parameters to calibrate: those selected, or the two with the smallest pooled
/// p-values if none is (a remark says so).
std::vector<std::string> choose_parameters(const doe::Screening& screening,
                                           std::vector<std::string>& remarks);

/// Points of the whole space whose coordinates of `names` are those given and 0.5 elsewhere.
Matrix embed(const Study& study, const std::vector<std::string>& names, const Matrix& reduced_unit);
/// The columns of `names` of points of the whole space.
Matrix project(const Study& study, const std::vector<std::string>& names, const Matrix& full_unit);

/// Simulated points with at least one usable run, their coordinates over `names`; `failed` holds
/// those with none. Screening points only where the plan lets surrogates use them.
struct VisitedPoints {
  Matrix usable;
  Matrix failed;
};
VisitedPoints visited_points(const Study& study, const Dataset& data,
                             const std::vector<std::string>& names);

/// Smallest expected weighted error among the points the surrogates were trained with.
double best_expected_error(const Study& study, const SurrogateSet& surrogates,
                           const Matrix& points);

/// The next batch, in coordinates over the surrogates' parameters.
Matrix propose(const Study& study, const SurrogateSet& surrogates, const VisitedPoints& visited,
               int batch);

/// The minimum of the expected weighted error over the unit cube, by the genetic algorithm; where
/// the nearest simulated point failed, nothing is searched.
struct Optimum {
  Vector unit;
  double expected_error = 0.0;
  double deviation = 0.0;  ///< of the weighted error there, by the surrogates
};
Optimum optimise(const Study& study, const SurrogateSet& surrogates, const VisitedPoints& visited);

/// The calibrated parameters with the ranges that the surrogates cannot tell apart.
std::vector<CalibratedParameter> parameter_ranges(const Study& study,
                                                  const SurrogateSet& surrogates,
                                                  const VisitedPoints& visited,
                                                  const Optimum& optimum);

/// The screening point with the smallest weighted error of its mean KPIs, in unit coordinates.
Vector best_screening_point(const Study& study, const Dataset& data);

/// Mean and deviation of a KPI over the usable runs of a phase.
MeanAndDeviation kpi_over(const Dataset& data, Phase phase, const std::string& kpi);

}  // namespace repose::dem_adapter
