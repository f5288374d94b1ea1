#include "repose/dem/run_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>
#include <utility>

#include "checkpoint/build_name.hpp"
#include "output/records.hpp"
#include "output/run_lock.hpp"
#include "output/run_state.hpp"
#include "parallel/communicator.hpp"
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

/// Wall and processor time, added up over the parts of a run that was stopped and went on.
class Stopwatch {
 public:
  void go_on_from(double wall_s, double processor_s) {
    wall_before_s_ = wall_s;
    processor_before_s_ = processor_s;
  }
  double wall_s() const {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin_;
    return wall_before_s_ + elapsed.count();
  }
  double processor_s() const {
    return processor_before_s_ +
           static_cast<double>(std::clock() - processor_begin_) / CLOCKS_PER_SEC;
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::clock_t processor_begin_ = std::clock();
  double wall_before_s_ = 0.0, processor_before_s_ = 0.0;
};

/// The checkpoint from which a run is to go on, if there is one.
std::optional<Checkpoint> checkpoint_of(const scene::Case& scene,
                                        const std::filesystem::path& run_dir, Start start) {
  const std::filesystem::path file = scene::checkpoint_file(run_dir);
  const bool is_there = Communicator::of_launcher().ask_root(
      [&] { return start != Start::anew && std::filesystem::exists(file); });
  if (!is_there) return std::nullopt;
  Checkpoint checkpoint = read_checkpoint(file);
  try {
    require_same_beginning(checkpoint, scene);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return checkpoint;
}

/// The build of the program that wrote it.
std::string builder_of(const Checkpoint& checkpoint) {
  const auto found = checkpoint.attributes.find("build");
  const auto* const name =
      found == checkpoint.attributes.end() ? nullptr : std::get_if<std::string>(&found->second);
  return name != nullptr ? *name : "of an unnamed build";
}

/// All stages, or those up to and with the one of this name.
std::size_t stages_until(const scene::Case& scene, const std::string& name) {
  if (name.empty()) return scene.stages.size();
  std::vector<std::string> names;
  for (const scene::Stage& stage : scene.stages) {
    names.push_back(stage.name);
    if (stage.name == name) return names.size();
  }
  throw InputError("until: stage \"" + name + "\" is not in the case; it has " + listed(names));
}

/// A run under way, on all ranks; root alone writes.
class Runner {
 public:
  Runner(const scene::Case& scene, const std::filesystem::path& run_dir, const RunControl& control)
      : Runner(scene, run_dir, control, checkpoint_of(scene, run_dir, control.start)) {}

  scene::RunSummary run() {
    try {
      run_all_stages();
    } catch (const RunStopped& stopped) {
      last_words(stopped.what());
      throw;
    } catch (const std::exception& error) {
      last_words(std::string("failed: ") + error.what());
      throw;
    }
    return summary_;
  }

 private:
  Runner(const scene::Case& scene, const std::filesystem::path& run_dir, const RunControl& control,
         const std::optional<Checkpoint>& saved)
      : scene_(scene),
        control_(control),
        stages_to_run_(stages_until(scene, control.until)),
        checkpoint_file_(scene::checkpoint_file(run_dir)),
        now_(saved ? run_state_of(*saved) : RunState{}),
        goes_on_(saved.has_value()),
        begun_by_(saved ? builder_of(*saved) : build_name()) {
    ranks_.on_root([&] {
      if (saved)
        writer_.emplace(run_dir, scene, now_.output);
      else
        writer_.emplace(run_dir, scene);
    });
    try {
      if (saved)
        sim_.emplace(scene, *saved, control.balance);
      else
        sim_.emplace(scene, SimulationOptions{.balance = control.balance});
    } catch (const std::exception& error) {
      last_words(std::string("failed: ") + error.what());
      throw;
    }
    watch_.go_on_from(now_.wall_time_s, now_.processor_time_s);
    last_checkpoint_s_ = watch_.wall_s();
  }

  void log(const std::string& line) {
    ranks_.on_root([&] { writer_->log(line); });
  }
  /// Where the others may be is not known.
  void last_words(const std::string& line) {
    if (writer_) writer_->log(line);
  }

  void run_all_stages() {
    prepare();
    for (std::size_t s = now_.stage; s < stages_to_run_; ++s) run_stage(s);
    if (!control_.until.empty()) return wait_for_more();
    require_all_rain();
    summarize();
    const double cpu_s = processor_s();
    if (!ranks_.is_alone())
      log(fmt::format("{} processes, the domain was cut {} times", ranks_.size(), sim_->cuts()));
    log(fmt::format(
        "finished: {} steps, {} builds of neighbor lists, {:.3g} s; processor time {:.3g} s, "
        "{:.3g} sphere-steps/s of it; {} bodies inserted, {} removed, {} alive; state {}",
        sim_->steps(), sim_->rebuilds(), summary_.wall_time_s, cpu_s,
        now_.sphere_steps / std::max(cpu_s, 1e-9), summary_.bodies.inserted,
        summary_.bodies.removed, summary_.bodies.alive, summary_.state_hash));
    if (now_.deepest.overlap.ratio() > kSoftOverlap) warn_of_soft_contact();
    ranks_.on_root([&] { writer_->finish(summary_); });
  }

  void wait_for_more() {
    save();
    summarize();
    log(fmt::format("waits at {:.6g} s, the end of stage \"{}\" or later; state {}", sim_->time_s(),
                    control_.until, summary_.state_hash));
  }

  /// Of all ranks.
  double processor_s() const {
    ExactSum sum[1];
    sum[0].add(watch_.processor_s());
    ranks_.add_up(sum);
    return sum[0].value();
  }

  void prepare() {
    dt_ = sim_->time_step_s();
    series_every_ = steps_of(scene_.output.series_interval_s, dt_);
    if (scene_.output.snapshot_interval_s > 0.0)
      snapshot_every_ = steps_of(scene_.output.snapshot_interval_s, dt_);
    if (goes_on_) {
      log(fmt::format("repose-dem {}: goes on from the checkpoint at {:.6g} s, step {}",
                      build_name(), sim_->time_s(), sim_->steps()));
      if (begun_by_ != build_name()) warn_of_other_build();
      return;
    }
    for (const std::string& line : head_of_log(scene_, *sim_)) log(line);
    if (!ranks_.is_alone()) log(fmt::format("{} processes", ranks_.size()));
    add_rows();
  }

  void require_all_rain() const {
    const double missing_kg = sim_->outstanding_rain_kg();
    if (missing_kg > 0.0)
      throw SimulationError(fmt::format(
          "{:.6g} kg of rain had not fallen when the last stage ended at {:.6g} s; {:.6g} kg are "
          "in; let stages last longer (minimum_s, duration_s) or rain faster",
          missing_kg, sim_->time_s(), sim_->ledger().inserted_kg));
  }

  void summarize() {
    summary_.steps = sim_->steps();
    summary_.time_step_s = dt_;
    summary_.spheres = static_cast<std::int64_t>(sim_->size());
    summary_.bodies = sim_->ledger();
    summary_.wall_time_s = watch_.wall_s();
    summary_.largest_overlap_ratio = now_.deepest.overlap.ratio();
    summary_.state_hash = fmt::format("{:016x}", sim_->state_hash());
    summary_.engine = "repose-dem";
    summary_.version = version();
    summary_.seed = scene_.seed;
    summary_.stages = now_.ends;
  }

  /// Begins a stage, or goes on with the one in which the checkpoint was written.
  StageWatch begin(std::size_t number) {
    const scene::Stage& stage = scene_.stages[number];
    if (now_.is_begun) return {scene_, stage, now_.watch};
    now_.is_begun = true;
    now_.latest_end_s = sim_->time_s() + longest_time_from(number);
    sim_->begin_stage(stage.name);
    now_.last_step = sim_->steps() + steps_of(stage.duration_s, dt_);
    StageWatch watch(scene_, stage, sim_->time_s());
    watch.ends_with(now_.last_row, rest_scale_j(stage));
    return watch;
  }

  void run_stage(std::size_t number) {
    StageWatch watch = begin(number);
    const scene::Stage& stage = scene_.stages[number];
    std::string reason;
    while (reason.empty()) {
      now_.watch = watch.progress();
      advance(stage.name);
      const bool is_last = sim_->steps() == now_.last_step;
      if (sim_->steps() % series_every_ == 0 || is_last) {
        add_rows();
        reason = watch.ends_with(now_.last_row, rest_scale_j(stage));
      }
      if (reason.empty() && is_last) reason = "duration";
      if (!reason.empty() || (snapshot_every_ > 0 && sim_->steps() % snapshot_every_ == 0)) {
        const scene::Snapshot snapshot = snapshot_of(scene_, stage.name, *sim_);
        ranks_.on_root([&] { writer_->write_snapshot(snapshot, sim_->wall_poses()); });
      }
    }
    now_.ends.push_back({stage.name, sim_->time_s(), reason});
    now_.stage = number + 1;
    now_.is_begun = false;
    log(fmt::format(
        "stage \"{}\" ended at {:.6g} s: {}; {} bodies, kinetic energy {:.4g} J, {} "
        "contacts, largest overlap so far {:.3g} of the radius",
        stage.name, sim_->time_s(), reason, sim_->ledger().alive, now_.last_row.kinetic_energy_j,
        now_.last_row.contacts, now_.deepest.overlap.ratio()));
  }

  /// Nothing is at rest as long as rain is to fall.
  double rest_scale_j(const scene::Stage& stage) const {
    return awaits_rain(scene_, stage.name, *sim_) ? 0.0 : now_.weight_scale_j;
  }

  /// To the next step at which something is written, in portions; before each, requests are heard.
  void advance(const std::string& stage) {
    const std::int64_t begun = sim_->steps();
    std::int64_t target = std::min(now_.last_step, (begun / series_every_ + 1) * series_every_);
    if (snapshot_every_ > 0)
      target = std::min(target, (begun / snapshot_every_ + 1) * snapshot_every_);
    while (sim_->steps() < target) {
      hear_requests();
      const double spheres = static_cast<double>(std::max<std::size_t>(sim_->size(), 1));
      const auto portion =
          std::max<std::int64_t>(1, static_cast<std::int64_t>(kWorkBetweenProgress / spheres));
      const std::int64_t steps = std::min(portion, target - sim_->steps());
      sim_->step(steps);
      now_.sphere_steps += static_cast<double>(steps) * static_cast<double>(sim_->size());
      ranks_.on_root([&] {
        if (control_.progress)
          control_.progress(sim_->time_s(), std::max(now_.latest_end_s, sim_->time_s()), stage);
      });
    }
  }

  void hear_requests() {
    const Request here = control_.request ? control_.request() : Request::none;
    const double interval_s = scene_.output.checkpoint_wall_time_s;
    const bool is_due = interval_s > 0.0 && watch_.wall_s() - last_checkpoint_s_ >= interval_s;
    double asked[3] = {here == Request::stop ? 1.0 : 0.0,
                       here == Request::write_checkpoint ? 1.0 : 0.0, is_due ? 1.0 : 0.0};
    ranks_.maximize(asked);  // signals may reach one rank alone
    // A signal reaches ranks one after the other; what was just served is not asked for again.
    if (std::exchange(has_served_, asked[1] > 0.0)) asked[1] = 0.0;
    if (asked[0] + asked[1] + asked[2] == 0.0) return;
    save();
    if (asked[0] > 0.0)
      throw RunStopped(fmt::format(
          "interrupted at {:.4g} of at most {:.4g} s; the same command goes on from there",
          sim_->time_s(), now_.latest_end_s));
    if (asked[1] > 0.0) log(fmt::format("checkpoint at {:.6g} s, as asked for", sim_->time_s()));
  }

  void save() {
    now_.wall_time_s = watch_.wall_s();
    now_.processor_time_s = processor_s();
    Checkpoint checkpoint = sim_->checkpoint();
    ranks_.on_root([&] {
      now_.output = writer_->position();
      add_to(checkpoint, now_);
      write_checkpoint(checkpoint_file_, checkpoint);
    });
    last_checkpoint_s_ = watch_.wall_s();
  }

  /// How long this stage and those after it last if none ends early.
  double longest_time_from(std::size_t stage) const {
    double time = 0.0;
    for (; stage < scene_.stages.size(); ++stage) time += scene_.stages[stage].duration_s;
    return time;
  }

  /// One row of every time series; loads on walls are of steps, so they begin after the first.
  void add_rows() {
    const BodySums sums = body_sums(scene_, *sim_);
    now_.weight_scale_j = sums.weight_scale_j;
    scene::SeriesRow& row = now_.last_row;
    row.time_s = sim_->time_s();
    row.kinetic_energy_j = sums.kinetic_energy_j;
    const LargestOverlap overlap = sim_->take_largest_overlap();
    note(overlap);
    row.max_overlap_ratio = overlap.ratio();
    row.contacts = static_cast<std::int64_t>(sim_->contacts());
    row.region_mass_kg = sums.region_mass_kg;
    std::optional<scene::WallRow> walls;
    if (!scene_.walls.empty() && sim_->steps() > 0) walls = wall_row_of(*sim_);
    const scene::ContactRow contacts{sim_->time_s(), sim_->contact_statistics()};
    std::optional<scene::EnergyRow> energy;
    if (scene_.output.energy) energy = sim_->energy();
    ranks_.on_root([&] {
      writer_->add_row(row);
      if (walls) writer_->add_row(*walls);
      writer_->add_row(contacts);
      if (energy) writer_->add_row(*energy);
    });
  }

  /// Warns when contacts are soft for the first time; once more at the end, of the deepest.
  void note(const LargestOverlap& overlap) {
    if (overlap.ratio() <= now_.deepest.overlap.ratio()) return;
    const bool was_soft = now_.deepest.overlap.ratio() > kSoftOverlap;
    const bool is_soft = overlap.ratio() > kSoftOverlap;
    now_.deepest = is_soft ? deep_contact(scene_, overlap, *sim_) : DeepContact{overlap};
    if (is_soft && !was_soft) warn_of_soft_contact();
  }

  void warn_of_other_build() {
    warn(fmt::format(
        "the checkpoint was written by repose-dem {}, this is {}: the bits of the result may be "
        "those of neither; to be sure, begin the run anew (--from-start)",
        begun_by_, build_name()));
  }

  void warn_of_soft_contact() { warn(soft_contact_text(scene_, now_.deepest)); }

  void warn(const std::string& text) {
    ranks_.on_root([&] {
      writer_->log("warning: " + text);
      if (control_.warn) control_.warn(text);
    });
  }

  const scene::Case& scene_;
  const RunControl& control_;
  std::size_t stages_to_run_;
  std::filesystem::path checkpoint_file_;
  Stopwatch watch_;
  RunState now_;
  bool goes_on_;
  std::string begun_by_;  // build of the program that wrote the checkpoint
  Communicator ranks_ = Communicator::of_launcher();
  std::optional<scene::RunWriter> writer_;  // on root
  std::optional<Simulation> sim_;
  scene::RunSummary summary_;
  double last_checkpoint_s_ = 0.0;  // of wall time
  bool has_served_ = false;         // a request for a checkpoint, when requests were last heard
  double dt_ = 0.0;
  std::int64_t series_every_ = 1;
  std::int64_t snapshot_every_ = 0;
};

/// The summary of a finished run of this case.
std::optional<scene::RunSummary> finished_run(const scene::Case& scene,
                                              const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const scene::Run run = scene::read_run(file);
    scene::Case finished = run.scene();
    finished.output.checkpoint_wall_time_s = scene.output.checkpoint_wall_time_s;
    if (finished == scene) return run.summary();
  } catch (const Error&) {
    // What cannot be read is of no use.
  }
  return std::nullopt;
}

/// A result that cannot be moved stays where it is.
void put_in_place(const std::filesystem::path& result, const std::filesystem::path& file) {
  std::error_code code;
  std::filesystem::rename(result, file, code);
  if (code)
    throw StorageError(fmt::format(
        "cannot move the result to '{}': {}; it is whole in '{}', and the same command moves it",
        file.string(), code.message(), result.string()));
}

/// Removes what is in the folder, but for the lock.
void remove_content(const std::filesystem::path& folder, const RunLock& lock) {
  std::error_code ignored;  // the result is in place; what is left behind does no harm
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path() != lock.file()) std::filesystem::remove_all(entry.path(), ignored);
}

}  // namespace

scene::RunSummary run_case(const scene::Case& scene, const std::filesystem::path& run_dir,
                           const RunControl& control) {
  scene::validate(scene);
  std::optional<RunLock> lock;  // root's
  Communicator::of_launcher().on_root([&] { lock.emplace(run_dir); });
  return Runner(scene, run_dir, control).run();
}

scene::RunSummary run_case_into_file(const scene::Case& scene, const std::filesystem::path& file,
                                     const RunControl& control) {
  scene::validate(scene);
  if (!control.until.empty())
    throw InputError("a run that waits after stage \"" + control.until +
                     "\" needs a folder for its output, not the file '" + file.string() + "'");
  if (std::filesystem::is_directory(file))
    throw StorageError("'" + file.string() + "' is a folder; give another name for the result");
  std::filesystem::path parts = file;
  parts += ".parts";
  const Communicator ranks = Communicator::of_launcher();
  std::optional<scene::RunSummary> summary;
  {
    std::optional<RunLock> lock;  // root's
    const bool is_finished = ranks.ask_root([&] {
      lock.emplace(parts);
      if (control.start == Start::where_stopped) summary = finished_run(scene, parts / "run.h5");
      return summary.has_value();
    });
    if (!is_finished) summary = Runner(scene, parts, control).run();
    ranks.on_root([&] {
      put_in_place(parts / "run.h5", file);
      remove_content(parts, *lock);
    });
  }
  ranks.on_root([&] {
    std::error_code ignored;
    std::filesystem::remove(parts, ignored);  // unless somebody runs there by now
  });
  return summary.value_or(scene::RunSummary{});  // root may have found what was finished
}

scene::RunSummary place_particles(const scene::Case& scene, const std::filesystem::path& run_dir) {
  scene::validate(scene);
  const RunLock lock(run_dir);
  scene::RunWriter writer(run_dir, scene);
  Simulation sim(scene);
  const BodySums sums = body_sums(scene, sim);
  writer.add_row(scene::SeriesRow{.time_s = 0.0,
                                  .kinetic_energy_j = sums.kinetic_energy_j,
                                  .max_overlap_ratio = sim.take_largest_overlap().ratio(),
                                  .contacts = static_cast<std::int64_t>(sim.contacts()),
                                  .region_mass_kg = sums.region_mass_kg});
  writer.write_snapshot(snapshot_of(scene, "", sim), sim.wall_poses());
  const scene::RunSummary summary{.time_step_s = sim.time_step_s(),
                                  .spheres = static_cast<std::int64_t>(sim.size()),
                                  .bodies = sim.ledger(),
                                  .state_hash = fmt::format("{:016x}", sim.state_hash()),
                                  .engine = "repose-dem",
                                  .version = version(),
                                  .seed = scene.seed,
                                  .stages = {}};
  writer.finish(summary);
  return summary;
}

}  // namespace repose::dem
