#include "repose/dem/run_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "output/records.hpp"
#include "output/stage_end.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem/simulation.hpp"

namespace repose::dem {
namespace {

/// Sphere-steps between two looks at the progress callback: below half a second of work.
constexpr double kWorkBetweenProgress = 1e6;

/// Stands for all that is longer; two of it still fit into an integer.
constexpr double kEndlessSteps = 0x1p60;

/// At least one.
std::int64_t steps_of(double duration_s, double dt) {
  return std::llround(std::clamp(duration_s / dt, 1.0, kEndlessSteps));
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
    for (std::size_t s = 0; s < scene_.stages.size(); ++s) {
      latest_end_s_ = sim.time_s() + longest_time_from(s);
      run_stage(sim, scene_.stages[s]);
    }
    require_all_rain(sim);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    summarize(sim, elapsed.count());
    const double cpu_s = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
    writer_.log(fmt::format(
        "finished: {} steps, {} builds of neighbor lists, {:.3g} s; processor time {:.3g} s, "
        "{:.3g} sphere-steps/s of it; {} bodies inserted, {} removed, {} alive",
        sim.steps(), sim.rebuilds(), elapsed.count(), cpu_s, sphere_steps_ / std::max(cpu_s, 1e-9),
        summary_.bodies.inserted, summary_.bodies.removed, summary_.bodies.alive));
    writer_.finish(summary_);
  }

  void prepare(Simulation& sim) {
    dt_ = sim.time_step_s();
    series_every_ = steps_of(scene_.output.series_interval_s, dt_);
    if (scene_.output.snapshot_interval_s > 0.0)
      snapshot_every_ = steps_of(scene_.output.snapshot_interval_s, dt_);
    for (const std::string& line : head_of_log(scene_, sim)) writer_.log(line);
    add_rows(sim);
  }

  void require_all_rain(const Simulation& sim) const {
    const double missing_kg = sim.outstanding_rain_kg();
    if (missing_kg > 0.0)
      throw SimulationError(fmt::format(
          "{:.6g} kg of rain had not fallen when the last stage ended at {:.6g} s; {:.6g} kg are "
          "in; let stages last longer (minimum_s, duration_s) or rain faster",
          missing_kg, sim.time_s(), sim.ledger().inserted_kg));
  }

  void summarize(const Simulation& sim, double wall_time_s) {
    summary_.steps = sim.steps();
    summary_.time_step_s = dt_;
    summary_.spheres = static_cast<std::int64_t>(sim.size());
    summary_.bodies = sim.ledger();
    summary_.wall_time_s = wall_time_s;
    summary_.engine = "repose-dem";
    summary_.version = version();
    summary_.seed = scene_.seed;
  }

  void run_stage(Simulation& sim, const scene::Stage& stage) {
    sim.begin_stage(stage.name);
    const std::int64_t last_step = sim.steps() + steps_of(stage.duration_s, dt_);
    StageWatch watch(scene_, stage, sim.time_s());
    watch.ends_with(last_row_, rest_scale_j(sim, stage));
    std::string reason;
    while (reason.empty()) {
      advance(sim, last_step, stage.name);
      const bool is_last = sim.steps() == last_step;
      if (sim.steps() % series_every_ == 0 || is_last) {
        add_rows(sim);
        reason = watch.ends_with(last_row_, rest_scale_j(sim, stage));
      }
      if (reason.empty() && is_last) reason = "duration";
      if (!reason.empty() || (snapshot_every_ > 0 && sim.steps() % snapshot_every_ == 0))
        writer_.write_snapshot(snapshot_of(scene_, stage.name, sim), sim.wall_poses());
    }
    summary_.stages.push_back({stage.name, sim.time_s(), reason});
    writer_.log(fmt::format(
        "stage \"{}\" ended at {:.6g} s: {}; {} bodies, kinetic energy {:.4g} J, {} "
        "contacts, largest overlap so far {:.3g} of the radius",
        stage.name, sim.time_s(), reason, sim.ledger().alive, last_row_.kinetic_energy_j,
        last_row_.contacts, summary_.largest_overlap_ratio));
  }

  /// Nothing is at rest as long as rain is to fall.
  double rest_scale_j(const Simulation& sim, const scene::Stage& stage) const {
    return awaits_rain(scene_, stage.name, sim) ? 0.0 : weight_scale_j_;
  }

  /// To the next step at which something is written, in portions between looks at the progress.
  void advance(Simulation& sim, std::int64_t last_step, const std::string& stage) {
    std::int64_t target = std::min(last_step, (sim.steps() / series_every_ + 1) * series_every_);
    if (snapshot_every_ > 0)
      target = std::min(target, (sim.steps() / snapshot_every_ + 1) * snapshot_every_);
    while (sim.steps() < target) {
      const double spheres = static_cast<double>(std::max<std::size_t>(sim.size(), 1));
      const auto portion =
          std::max<std::int64_t>(1, static_cast<std::int64_t>(kWorkBetweenProgress / spheres));
      const std::int64_t steps = std::min(portion, target - sim.steps());
      sim.step(steps);
      sphere_steps_ += static_cast<double>(steps) * static_cast<double>(sim.size());
      if (progress_) progress_(sim.time_s(), std::max(latest_end_s_, sim.time_s()), stage);
    }
  }

  /// How long this stage and those after it last if none ends early.
  double longest_time_from(std::size_t stage) const {
    double time = 0.0;
    for (; stage < scene_.stages.size(); ++stage) time += scene_.stages[stage].duration_s;
    return time;
  }

  /// One row of every time series; loads on walls are of steps, so they begin after the first.
  void add_rows(Simulation& sim) {
    const std::vector<Body> bodies = sim.bodies();
    weight_scale_j_ = weight_scale_j(scene_, bodies);
    last_row_.time_s = sim.time_s();
    last_row_.kinetic_energy_j = 0.0;
    for (const Body& body : bodies) last_row_.kinetic_energy_j += body.kinetic_energy_j();
    last_row_.max_overlap_ratio = sim.take_largest_overlap_ratio();
    last_row_.contacts = static_cast<std::int64_t>(sim.contacts());
    last_row_.region_mass_kg = region_masses(scene_, bodies);
    summary_.largest_overlap_ratio =
        std::max(summary_.largest_overlap_ratio, last_row_.max_overlap_ratio);
    writer_.add_row(last_row_);
    if (!scene_.walls.empty() && sim.steps() > 0) writer_.add_row(wall_row_of(sim));
    writer_.add_row(scene::ContactRow{sim.time_s(), sim.contact_statistics()});
    if (scene_.output.energy) writer_.add_row(sim.energy());
  }

  const scene::Case& scene_;
  const ProgressCallback& progress_;
  scene::RunWriter writer_;
  scene::RunSummary summary_;
  scene::SeriesRow last_row_;
  double weight_scale_j_ = 0.0;  // of the last row
  double sphere_steps_ = 0.0;
  double dt_ = 0.0;
  double latest_end_s_ = 0.0;  // of the run, as known from what stages have ended
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
