// When a stage is over.
#pragma once

#include <deque>
#include <string>

#include "repose/scene/run_output.hpp"

namespace repose::dem {

/// Watches the rows of the series during one stage.
class StageWatch {
 public:
  StageWatch(const scene::Case& scene, const scene::Stage& stage, double start_s);

  /// Why the stage ends with this row: "at rest", "flow ended", or "" if it goes on.
  /// `weight_scale_j` is sum(m) g d_mean of the particles that are there; at 0 nothing is at rest.
  std::string ends_with(const scene::SeriesRow& row, double weight_scale_j);

 private:
  bool came_to_rest(const scene::SeriesRow& row, double weight_scale_j);
  bool flow_ended(const scene::SeriesRow& row);

  struct MassAt {
    double time_s, mass_kg;
  };
  scene::Stage stage_;
  double start_s_;
  double moving_until_s_;  // the last row above the energy limit
  std::size_t region_column_ = 0;
  std::deque<MassAt> masses_;  // of the last window, oldest first
  double initial_mass_ = -1.0;
};

}  // namespace repose::dem
