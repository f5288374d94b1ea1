// When a stage is over.
#pragma once

#include <deque>
#include <string>

#include "repose/scene/run_output.hpp"

namespace repose::dem {

/// Watches the rows of the series during one stage.
class StageWatch {
 public:
  struct MassAt {
    double time_s, mass_kg;
  };
  /// All that it remembers of the rows.
  struct Progress {
    double start_s = 0.0;
    double moving_until_s = 0.0;    ///< the last row above the energy limit
    double initial_mass_kg = -1.0;  ///< in the region that is to empty; negative before a row
    std::deque<MassAt> masses;      ///< of the last window, oldest first
  };

  /// For a stage that begins now, or goes on.
  StageWatch(const scene::Case& scene, const scene::Stage& stage, double start_s);
  StageWatch(const scene::Case& scene, const scene::Stage& stage, const Progress& progress);

  /// Why the stage ends with this row: "at rest", "flow ended", or "" if it goes on.
  /// `weight_scale_j` is sum(m) g d_mean of the particles that are there; at 0 nothing is at rest.
  std::string ends_with(const scene::SeriesRow& row, double weight_scale_j);
  const Progress& progress() const { return now_; }

 private:
  bool came_to_rest(const scene::SeriesRow& row, double weight_scale_j);
  bool flow_ended(const scene::SeriesRow& row);

  scene::Stage stage_;
  std::size_t region_column_ = 0;
  Progress now_;
};

}  // namespace repose::dem
