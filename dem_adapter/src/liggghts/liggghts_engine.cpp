#include "repose/dem_adapter/liggghts.hpp"

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <numeric>
#include <sstream>

#include "engine/programs.hpp"
#include "engine/repose_dem.hpp"
#include "output.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_output.hpp"
#include "run_folder.hpp"
#include "script.hpp"
#include "wall_bodies.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;
using namespace liggghts;

/// The content of a program and of the libraries of LIGGGHTS that it loads, which hold most of it.
std::string content_with_libraries(const fs::path& program) {
  auto text = content_of(program);
  const auto said = fs::temp_directory_path() /
                    fmt::format("repose_ldd_{}_{}", ::getpid(), content_hash(program.string()));
  const auto ldd = find_program("ldd", "install libc-bin");
  static_cast<void>(LocalExecutor().run({.words = {ldd.string(), program.string()}, .log = said}));
  std::istringstream lines(read_file(said));
  for (std::string line; std::getline(lines, line);) {
    const auto from = line.find("/"), to = line.find(" (");
    if (line.find("liggghts") == std::string::npos || from == std::string::npos) continue;
    if (const fs::path library = line.substr(from, to - from); fs::is_regular_file(library))
      text += content_of(library);
  }
  std::error_code ignored;
  fs::remove(said, ignored);
  return fmt::format("{:016x}", content_hash(text));
}

/// Sides of the box, diameters, densities, places and velocities.
std::string data_text(const scene::Case& scene, const scene::Snapshot& start, const Box& box) {
  auto text = fmt::format("Written by repose.\n\n{} atoms\n{} atom types\n\n", start.size(),
                          scene.materials.size());
  for (int k = 0; k < 3; ++k)
    text += fmt::format("{0} {1} {2}lo {2}hi\n", shortest(box.lower[k]), shortest(box.upper[k]),
                        "xyz"[k]);
  text += "\nAtoms\n\n";
  for (std::size_t i = 0; i < start.size(); ++i) {
    const auto m = static_cast<std::size_t>(start.material[i]);
    const auto& x = start.position[i];
    text += fmt::format("{} {} {} {} {} {} {}\n", i + 1, m + 1, shortest(2.0 * start.radius_m[i]),
                        shortest(scene.materials[m].density_kg_m3), shortest(x.x()),
                        shortest(x.y()), shortest(x.z()));
  }
  text += "\nVelocities\n\n";
  for (std::size_t i = 0; i < start.size(); ++i) {
    const auto &v = start.velocity[i], &w = start.angular_velocity[i];
    text += fmt::format("{} {} {} {} {} {} {}\n", i + 1, shortest(v.x()), shortest(v.y()),
                        shortest(v.z()), shortest(w.x()), shortest(w.y()), shortest(w.z()));
  }
  return text;
}

Particles particles_of(const scene::Case& scene, const scene::Snapshot& start, double dt) {
  const auto n = static_cast<double>(start.size());
  const double mass = std::accumulate(start.mass_kg.begin(), start.mass_kg.end(), 0.0);
  const double radii = std::accumulate(start.radius_m.begin(), start.radius_m.end(), 0.0);
  return {.time_step_s = dt,
          .smallest_radius_m = *std::min_element(start.radius_m.begin(), start.radius_m.end()),
          .weight_scale_j = mass * scene.gravity_m_s2.norm() * 2.0 * radii / n};
}

/// The failures of LIGGGHTS that have a name.
Outcome outcome_of(const std::string& error) {
  if (error.find("Lost atoms") != std::string::npos) return Outcome::particles_lost;
  if (error.find("NaN") != std::string::npos || error.find("nan") != std::string::npos)
    return Outcome::non_finite;
  return Outcome::engine_failed;
}

EngineExit failed(EngineExit exit, Outcome outcome, std::string message) {
  exit.status = EngineStatus::failed;
  exit.failure = outcome;
  exit.message = std::move(message);
  return exit;
}

}  // namespace

LiggghtsEngine::LiggghtsEngine(LiggghtsPrograms programs, Executor executor)
    : programs_(std::move(programs)), executor_(std::move(executor)) {
  const auto find = [](fs::path& program, const char* name, const char* remedy) {
    program = fs::absolute(program.empty() ? find_program(name, remedy) : program);
    check_executable(program);
  };
  find(programs_.liggghts, "liggghts", "install Debian's package liggghts");
  find(programs_.repose_dem, "repose-dem", "build or install it");
  find(programs_.stdbuf, "stdbuf", "install Debian's package coreutils");
  name_ = fmt::format("liggghts build {} placed by {}", content_with_libraries(programs_.liggghts),
                      content_of(programs_.repose_dem));
}

EngineExit LiggghtsEngine::place(const EngineJob& job, const fs::path& placed) const {
  const Command command{
      .words = {programs_.repose_dem.string(), (job.directory / "case.toml").string(), "-o",
                placed.string(), "--place", "--quiet"},
      .log = job.directory / "engine.log",
      .time_limit_s = job.time_limit_s,
      .cancelled = job.cancelled};
  const auto said_before = size_of(command.log);
  return exit_of_repose_dem(executor_.run(command), command, said_before);
}

Command LiggghtsEngine::command_of(const EngineJob& job, const fs::path& folder) const {
  Command command{.words = {},
                  .folder = folder,
                  .log = job.directory / "engine.log",
                  .processes = job.ranks,
                  .time_limit_s = job.time_limit_s,
                  .cancelled = job.cancelled};
  if (job.ranks > 1) {
    const auto mpirun = programs_.mpirun.empty()
                            ? find_program("mpirun", "install Debian's package openmpi-bin")
                            : programs_.mpirun;
    command.words = {
        mpirun.string(), "--allow-run-as-root",    "--oversubscribe", "--bind-to", "none",
        "-np",           std::to_string(job.ranks)};
  }
  // An abort would take with it what is still in its buffers: its reasons.
  for (const auto& word :
       {programs_.stdbuf.string(), std::string("-o0"), programs_.liggghts.string(),
        std::string("-in"), std::string("in.liggghts"), std::string("-log"), std::string("none")})
    command.words.push_back(word);
  return command;
}

EngineExit LiggghtsEngine::run(const EngineJob& job) const {
  const auto scene = scene::read_case(job.directory / "case.toml");
  require_possible(scene);
  const auto bodies = wall_bodies(scene);
  const auto output = job.directory / "output", folder = output / "liggghts";
  remove_whole(output);
  auto exit = place(job, output / "placed");
  if (exit.status != EngineStatus::finished) return exit;
  const auto placed = scene::read_run(output / "placed");
  const auto start = placed.snapshot(0);
  if (start.size() == 0)
    throw InputError("the case has no particles at its start; the engine liggghts needs some");
  if (placed.summary().bodies.alive != static_cast<std::int64_t>(start.size()))
    throw InputError("the case has clumps; the engine liggghts simulates single spheres");
  const auto particles = particles_of(scene, start, placed.summary().time_step_s);
  make_directory(folder);
  write_file_atomically(folder / "particles.data", data_text(scene, start, box_of(scene, bodies)));
  for (const auto& body : bodies)
    if (!body.plane) write_stl(folder / (body.id + ".stl"), body.mesh);
  write_file_atomically(folder / "in.liggghts", script_text(scene, bodies, particles));
  const auto command = command_of(job, folder);
  const auto said_before = size_of(command.log);
  auto used = exit.resources;  // for placing
  const auto end = executor_.run(command);
  exit = exit_of(end, command, said_before);
  used += exit.resources;
  used.parts = 1;
  exit.resources = used;
  if (exit.status != EngineStatus::finished && exit.status != EngineStatus::failed) return exit;
  const auto log = parse_log(read_file(command.log));
  if (exit.status == EngineStatus::failed) {
    if (exit.failure == Outcome::crash) return exit;
    const auto reason = log.error.empty() ? exit.message : log.error;
    return failed(exit, outcome_of(reason), reason);
  }
  if (log.ends.size() != scene.stages.size())
    return failed(exit, Outcome::engine_failed, "LIGGGHTS ended before the last stage did");
  remove_whole(output / "placed");
  scene::RunWriter writer(output, scene);
  writer.log(fmt::format("liggghts {}: {} spheres, time step {} s, {} processes", log.version,
                         start.size(), shortest(particles.time_step_s), job.ranks));
  const scene::RunSummary summary{.time_step_s = particles.time_step_s,
                                  .spheres = static_cast<std::int64_t>(start.size()),
                                  .bodies = placed.summary().bodies,
                                  .wall_time_s = exit.resources.wall_time_s,
                                  .state_hash = "",
                                  .engine = "liggghts",
                                  .version = log.version,
                                  .seed = scene.seed,
                                  .stages = {}};
  if (const auto defect = write_run(scene, start, log, folder, summary, writer))
    return failed(exit, defect->outcome, defect->message);
  std::error_code ignored;  // all of it is in run.h5 now
  fs::remove(folder / "frames.dump", ignored);
  for (std::size_t s = 0; s < scene.stages.size(); ++s)
    fs::remove(folder / fmt::format("stage_{}.dump", s), ignored);
  return exit;
}

}  // namespace repose::dem_adapter
