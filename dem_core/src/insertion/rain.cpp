#include "insertion/rain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

constexpr std::uint64_t kFirstStream = 1ULL << 32;  // above those of the fill
constexpr int kTries = 200;                         // for one particle at one time
constexpr double kLongestDelay_s = 1.0;

}  // namespace

RainSource::RainSource(const scene::Case& scene, std::size_t number, ClumpForms& forms)
    : rain_(scene.rains[number]), seed_(scene.seed), stream_(kFirstStream + 2 * number) {
  RandomStream random(seed_, stream_);
  grains_ = draw_mixture(scene, rain_.mixture, rain_.mass_kg, random);
  random.shuffle(grains_);
  for (const scene::Grains& kind : rain_.mixture) forms_.push_back(forms.find(kind.clump));
  if (grains_.empty())
    throw InputError("rain \"" + rain_.name + "\": mass_kg = " + shortest(rain_.mass_kg) +
                     ": is less than half of its smallest particle; nothing would fall");
  for (std::size_t k = 0; k < forms_.size(); ++k) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Grain& grain : grains_) {
      if (static_cast<std::size_t>(grain.kind) != k) continue;
      const double radius = 0.5 * grain.diameter;
      smallest =
          std::min(smallest, radius * (forms_[k] == nullptr ? 1.0 : forms_[k]->smallest_radius));
      largest_radius_ = std::max(largest_radius_, radius * ClumpForms::largest_sphere(forms_[k]));
    }
    if (std::isfinite(smallest)) smallest_.push_back({rain_.mixture[k].material, smallest});
  }
}

double RainSource::smallest_radius() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Smallest& of_kind : smallest_) smallest = std::min(smallest, of_kind.radius);
  return smallest;
}

void RainSource::go_on_from(const Progress& progress) {
  if (progress.placed < 0 || progress.placed > static_cast<std::int64_t>(grains_.size()))
    throw StorageError("a checkpoint has " + std::to_string(progress.placed) + " of " +
                       std::to_string(grains_.size()) + " particles of rain \"" + rain_.name +
                       "\"; begin the run anew");
  next_ = static_cast<std::size_t>(progress.placed);
  attempts_ = static_cast<std::uint64_t>(progress.attempts);
  placed_kg_ = progress.placed_kg;
}

bool RainSource::is_due(double time_s) const {
  return !is_finished() && placed_kg_ + 0.5 * grains_[next_].mass <= rain_.mass_rate_kg_s * time_s;
}

std::vector<scene::Particle> RainSource::fall(double time_s, const Box& box,
                                              const ClearOfWalls& clear_of_walls,
                                              OccupiedSpace& occupied) {
  std::vector<scene::Particle> fallen;
  const PlacingBox where{rain_.lower, rain_.upper};
  RandomStream random(derive_seed(seed_, ++attempts_), stream_ + 1);
  while (is_due(time_s)) {
    const Grain& grain = grains_[next_];
    const auto kind = static_cast<std::size_t>(grain.kind);
    scene::Particle particle;
    particle.material = rain_.mixture[kind].material;
    particle.clump = rain_.mixture[kind].clump;
    particle.radius_m = 0.5 * grain.diameter;
    particle.velocity = rain_.velocity;
    if (!find_place(where, box, occupied, clear_of_walls, forms_[kind], kTries, random, particle))
      break;
    occupy(particle, forms_[kind], box, occupied);
    placed_kg_ += grain.mass;
    ++next_;
    fallen.push_back(particle);
  }
  const double due = std::min(rain_.mass_kg, rain_.mass_rate_kg_s * time_s);
  if (!is_finished() && due - placed_kg_ > kLongestDelay_s * rain_.mass_rate_kg_s)
    throw SimulationError("rain \"" + rain_.name + "\": " + std::to_string(next_) + " of " +
                          std::to_string(grains_.size()) + " particles, " + shortest(placed_kg_) +
                          " kg, have come, but " + shortest(due) +
                          " kg are due: there is no room in its box; make the box larger, give "
                          "the particles a velocity that clears it, or lower mass_rate_kg_s = " +
                          shortest(rain_.mass_rate_kg_s));
  return fallen;
}

}  // namespace repose::dem
