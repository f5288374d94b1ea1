#include "output/stage_end.hpp"

namespace repose::dem {

StageWatch::StageWatch(const scene::Case& scene, const scene::Stage& stage, double start_s)
    : stage_(stage), start_s_(start_s), moving_until_s_(start_s) {
  if (!stage.flow_ends) return;
  for (std::size_t r = 0; r < scene.regions.size(); ++r)
    if (scene.regions[r].name == stage.flow_ends->region)
      region_column_ = r * (1 + scene.materials.size());
}

std::string StageWatch::ends_with(const scene::SeriesRow& row, double weight_scale_j) {
  const bool at_rest = stage_.at_rest && came_to_rest(row, weight_scale_j);
  const bool ended = stage_.flow_ends && flow_ended(row);
  if (row.time_s - start_s_ < stage_.minimum_s) return "";
  return at_rest ? "at rest" : ended ? "flow ended" : "";
}

bool StageWatch::came_to_rest(const scene::SeriesRow& row, double weight_scale_j) {
  if (weight_scale_j == 0.0 ||
      row.kinetic_energy_j > stage_.at_rest->kinetic_energy_ratio * weight_scale_j)
    moving_until_s_ = row.time_s;
  return row.time_s - moving_until_s_ >= stage_.at_rest->window_s;
}

bool StageWatch::flow_ended(const scene::SeriesRow& row) {
  const double mass = row.region_mass_kg.at(region_column_);
  if (initial_mass_ < 0.0) initial_mass_ = mass;
  masses_.push_back({row.time_s, mass});
  const double window_start = row.time_s - stage_.flow_ends->window_s;
  while (masses_.size() > 1 && masses_[1].time_s <= window_start) masses_.pop_front();
  if (masses_.front().time_s > window_start) return false;
  const double left = initial_mass_ - mass;
  const double scale = left > 0.0 ? left : initial_mass_;
  return masses_.front().mass_kg - mass < stage_.flow_ends->fraction * scale;
}

}  // namespace repose::dem
