#include "repose/dem/run_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "output/stage_end.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem/simulation.hpp"

namespace repose::dem {
namespace {

/// Sphere-steps between two looks at the progress callback: below half a second of work.
constexpr double kWorkBetweenProgress = 1e6;

std::int64_t steps_of(double duration_s, double dt) {
  return std::max<std::int64_t>(1, std::llround(duration_s / dt));
}

std::vector<double> region_masses(const scene::Case& scene, const std::vector<Sphere>& spheres) {
  const std::size_t width = 1 + scene.materials.size();
  std::vector<double> masses(scene.regions.size() * width, 0.0);
  for (std::size_t r = 0; r < scene.regions.size(); ++r) {
    const scene::Region& region = scene.regions[r];
    for (const Sphere& s : spheres) {
      if ((s.position.array() < region.lower.array()).any() ||
          (s.position.array() >= region.upper.array()).any())
        continue;
      masses[r * width] += s.mass_kg;
      masses[r * width + 1 + static_cast<std::size_t>(s.material)] += s.mass_kg;
    }
  }
  return masses;
}

scene::Snapshot snapshot_of(const scene::Case& scene, const std::string& stage, double time_s,
                            const std::vector<Sphere>& spheres) {
  scene::Snapshot snapshot;
  snapshot.time_s = time_s;
  snapshot.stage = stage;
  for (const scene::Material& material : scene.materials)
    snapshot.materials.push_back(material.name);
  for (const Sphere& s : spheres) {
    snapshot.id.push_back(s.id);
    snapshot.body.push_back(s.id);
    snapshot.material.push_back(s.material);
    snapshot.radius_m.push_back(s.radius_m);
    snapshot.mass_kg.push_back(s.mass_kg);
    snapshot.position.push_back(s.position);
    snapshot.velocity.push_back(s.velocity);
    snapshot.angular_velocity.push_back(s.angular_velocity);
  }
  return snapshot;
}

/// A run under way.
class Runner {
 public:
  Runner(const scene::Case& scene, const std::filesystem::path& run_dir,
         const ProgressCallback& progress)
      : scene_(scene), progress_(progress), writer_(run_dir, scene) {}

  scene::RunSummary run() {
    try {
      run_all_stages();
    } catch (const std::exception& error) {
      writer_.log(std::string("failed: ") + error.what());
      throw;
    }
    return summary_;
  }

 private:
  void run_all_stages() {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t cpu_begin = std::clock();
    Simulation sim(scene_);
    prepare(sim);
    for (const scene::Stage& stage : scene_.stages) run_stage(sim, stage);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    summary_.steps = sim.steps();
    summary_.wall_time_s = elapsed.count();
    const double cpu_s = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
    const double work = static_cast<double>(sim.steps()) * static_cast<double>(sim.size());
    writer_.log(fmt::format(
        "finished: {} steps, {} builds of neighbor lists, {:.3g} s; processor time {:.3g} s, "
        "{:.3g} "
        "sphere-steps/s of it",
        sim.steps(), sim.rebuilds(), elapsed.count(), cpu_s, work / std::max(cpu_s, 1e-9)));
    writer_.finish(summary_);
  }

  void prepare(Simulation& sim) {
    dt_ = sim.time_step_s();
    series_every_ = steps_of(scene_.output.series_interval_s, dt_);
    if (scene_.output.snapshot_interval_s > 0.0)
      snapshot_every_ = steps_of(scene_.output.snapshot_interval_s, dt_);
    for (const scene::Stage& stage : scene_.stages) total_s_ += stage.duration_s;
    summary_.time_step_s = dt_;
    summary_.spheres = static_cast<std::int64_t>(sim.size());
    summary_.bodies = {.inserted = summary_.spheres,
                       .removed = 0,
                       .alive = summary_.spheres,
                       .inserted_kg = sim.mass_kg(),
                       .removed_kg = 0.0,
                       .alive_kg = sim.mass_kg()};
    summary_.engine = "repose-dem";
    summary_.version = version();
    summary_.seed = scene_.seed;
    double diameters = 0.0;
    double smallest = 1e300;
    double largest = 0.0;
    for (const Sphere& s : sim.spheres()) {
      diameters += 2.0 * s.radius_m;
      smallest = std::min(smallest, 2.0 * s.radius_m);
      largest = std::max(largest, 2.0 * s.radius_m);
    }
    weight_scale_j_ =
        sim.mass_kg() * scene_.gravity_m_s2.norm() * diameters / static_cast<double>(sim.size());
    writer_.log(fmt::format(
        "repose-dem {}: {} spheres of {} to {} m, {:.9g} kg; time step {} s = {} of the smallest "
        "Rayleigh time; law hm1 (Hertz-Mindlin, rolling type C), attraction before separation "
        "kept; seed {}",
        version(), sim.size(), shortest(smallest), shortest(largest), sim.mass_kg(), shortest(dt_),
        shortest(scene_.time_step_rayleigh_fraction), scene_.seed));
    for (const scene::PairCoefficients& p : scene_.pairs)
      writer_.log(fmt::format("pair {} - {}: restitution {}, mu_s {}, mu_r {}, rolling damping {}",
                              p.first, p.second, shortest(p.restitution), shortest(p.mu_s),
                              shortest(p.mu_r), shortest(p.rolling_damping)));
    add_rows(sim);
  }

  void run_stage(Simulation& sim, const scene::Stage& stage) {
    sim.begin_stage(stage.name);
    const std::int64_t last_step = sim.steps() + steps_of(stage.duration_s, dt_);
    StageWatch watch(scene_, stage, sim.time_s(), weight_scale_j_);
    watch.ends_with(last_row_);
    std::string reason;
    while (reason.empty()) {
      advance(sim, last_step, stage.name);
      const bool is_last = sim.steps() == last_step;
      if (sim.steps() % series_every_ == 0 || is_last) {
        add_rows(sim);
        reason = watch.ends_with(last_row_);
      }
      if (reason.empty() && is_last) reason = "duration";
      if (!reason.empty() || (snapshot_every_ > 0 && sim.steps() % snapshot_every_ == 0))
        writer_.write_snapshot(snapshot_of(scene_, stage.name, sim.time_s(), sim.spheres()),
                               sim.wall_poses());
    }
    summary_.stages.push_back({stage.name, sim.time_s(), reason});
    planned_s_ += stage.duration_s;
    writer_.log(
        fmt::format("stage \"{}\" ended at {:.6g} s: {}; kinetic energy {:.4g} J, {} "
                    "contacts, largest overlap so far {:.3g} of the radius",
                    stage.name, sim.time_s(), reason, last_row_.kinetic_energy_j,
                    last_row_.contacts, summary_.largest_overlap_ratio));
  }

  /// To the next step at which something is written, in portions between looks at the progress.
  void advance(Simulation& sim, std::int64_t last_step, const std::string& stage) {
    std::int64_t target = std::min(last_step, (sim.steps() / series_every_ + 1) * series_every_);
    if (snapshot_every_ > 0)
      target = std::min(target, (sim.steps() / snapshot_every_ + 1) * snapshot_every_);
    const auto portion = std::max<std::int64_t>(
        1, static_cast<std::int64_t>(kWorkBetweenProgress / static_cast<double>(sim.size())));
    while (sim.steps() < target) {
      sim.step(std::min(portion, target - sim.steps()));
      const double stage_s = static_cast<double>(last_step - sim.steps()) * dt_;
      if (progress_) progress_(std::max(0.0, done_s(stage, stage_s)), total_s_, stage);
    }
  }

  /// Planned time passed: that of finished stages and what has gone of this one.
  double done_s(const std::string& name, double left_of_stage_s) const {
    for (const scene::Stage& stage : scene_.stages)
      if (stage.name == name) return planned_s_ + stage.duration_s - left_of_stage_s;
    return planned_s_;
  }

  /// One row of every time series; the first one is before the first step and has no loads.
  void add_rows(Simulation& sim) {
    add_series_row(sim);
    if (!scene_.walls.empty() && sim.steps() > 0) add_wall_row(sim);
  }

  void add_wall_row(Simulation& sim) {
    scene::WallRow row{.time_s = sim.time_s()};
    for (const WallLoad& load : sim.take_wall_loads()) {
      row.force_n.push_back(load.force_n);
      row.torque_n_m.push_back(load.torque_n_m);
    }
    writer_.add_row(row);
  }

  void add_series_row(Simulation& sim) {
    last_row_.time_s = sim.time_s();
    last_row_.kinetic_energy_j = sim.kinetic_energy_j();
    last_row_.max_overlap_ratio = sim.take_largest_overlap_ratio();
    last_row_.contacts = static_cast<std::int64_t>(sim.contacts());
    last_row_.region_mass_kg = region_masses(scene_, sim.spheres());
    summary_.largest_overlap_ratio =
        std::max(summary_.largest_overlap_ratio, last_row_.max_overlap_ratio);
    writer_.add_row(last_row_);
  }

  const scene::Case& scene_;
  const ProgressCallback& progress_;
  scene::RunWriter writer_;
  scene::RunSummary summary_;
  scene::SeriesRow last_row_;
  double dt_ = 0.0;
  double weight_scale_j_ = 0.0;
  double total_s_ = 0.0;
  double planned_s_ = 0.0;
  std::int64_t series_every_ = 1;
  std::int64_t snapshot_every_ = 0;
};

}  // namespace

scene::RunSummary run_case(const scene::Case& scene, const std::filesystem::path& run_dir,
                           const ProgressCallback& progress) {
  scene::validate(scene);
  return Runner(scene, run_dir, progress).run();
}

}  // namespace repose::dem
