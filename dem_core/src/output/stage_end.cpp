#include "output/stage_end.hpp"

namespace repose::dem {

StageWatch::StageWatch(const scene::Case& scene, const scene::Stage& stage, double start_s)
    : StageWatch(scene, stage, Progress{.start_s = start_s, .moving_until_s = start_s}) {}

StageWatch::StageWatch(const scene::Case& scene, const scene::Stage& stage,
                       const Progress& progress)
    : stage_(stage), now_(progress) {
  if (!stage.flow_ends) return;
  for (std::size_t r = 0; r < scene.regions.size(); ++r)
    if (scene.regions[r].name == stage.flow_ends->region)
      region_column_ = r * (1 + scene.materials.size());
}

std::string StageWatch::ends_with(const scene::SeriesRow& row, double weight_scale_j) {
  const bool at_rest = stage_.at_rest && came_to_rest(row, weight_scale_j);
  const bool ended = stage_.flow_ends && flow_ended(row);
  if (row.time_s - now_.start_s < stage_.minimum_s) return "";
  return at_rest ? "at rest" : ended ? "flow ended" : "";
}

bool StageWatch::came_to_rest(const scene::SeriesRow& row, double weight_scale_j) {
  if (weight_scale_j == 0.0 ||
      row.kinetic_energy_j > stage_.at_rest->kinetic_energy_ratio * weight_scale_j)
    now_.moving_until_s = row.time_s;
  return row.time_s - now_.moving_until_s >= stage_.at_rest->window_s;
}

bool StageWatch::flow_ended(const scene::SeriesRow& row) {
  const double mass = row.region_mass_kg.at(region_column_);
  if (now_.initial_mass_kg < 0.0) now_.initial_mass_kg = mass;
  now_.masses.push_back({row.time_s, mass});
  const double window_start = row.time_s - stage_.flow_ends->window_s;
  while (now_.masses.size() > 1 && now_.masses[1].time_s <= window_start) now_.masses.pop_front();
  if (now_.masses.front().time_s > window_start) return false;
  const double left = now_.initial_mass_kg - mass;
  const double scale = left > 0.0 ? left : now_.initial_mass_kg;
  return now_.masses.front().mass_kg - mass < stage_.flow_ends->fraction * scale;
}

}  // namespace repose::dem
