// How fast the engine advances a case, and what it holds in memory: repose_dem_rate CASE STEPS,
// also under mpirun.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "parallel/communicator.hpp"
#include "repose/dem/simulation.hpp"
#include "repose/scene/case.hpp"

namespace {

/// What the process has in memory now, bytes.
double resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  statm >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

struct Seconds {
  double wall, processor;
};
Seconds seconds_of(repose::dem::Simulation& simulation, std::int64_t steps) {
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  simulation.step(steps);
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC};
}

struct Request {
  std::filesystem::path file;
  std::int64_t steps = 1000;
  std::int64_t warm = 100;
  double time_step_s = 0.0;
  std::string opens{};
  double open_at_s = 0.0;
  double until_s = 0.0;
};

void measure(const Request& request) {
  const repose::scene::Case scene = repose::scene::read_case(request.file);
  const double before = resident_bytes();
  repose::dem::Simulation simulation(scene, {.time_step_s = request.time_step_s});
  while (simulation.time_s() < request.open_at_s) simulation.step(100);
  if (!request.opens.empty()) simulation.open(request.opens);
  while (simulation.time_s() < request.until_s) simulation.step(100);
  simulation.step(request.warm);
  const std::int64_t rebuilds = simulation.rebuilds();
  const Seconds seconds = seconds_of(simulation, request.steps);
  const auto spheres = static_cast<double>(simulation.size());
  const std::size_t contacts = simulation.contacts();
  const double kinetic_energy_j = simulation.kinetic_energy_j();
  const auto ranks = repose::dem::Communicator::of_launcher();
  if (!ranks.is_root()) return;
  std::printf(
      "repose ranks=%d loop_s=%.4f sphere_steps_per_s=%.4g processor_s=%.4f spheres=%zu "
      "contacts=%zu rebuilds=%lld "
      "bytes_per_sphere=%.0f kinetic_energy_j=%.6g\n",
      ranks.size(), seconds.wall, spheres * static_cast<double>(request.steps) / seconds.wall,
      seconds.processor, simulation.size(), contacts,
      static_cast<long long>(simulation.rebuilds() - rebuilds),
      (resident_bytes() - before) / spheres, kinetic_energy_j);
}

}  // namespace

int main(int argc, char** argv) {
  std::optional<repose::dem::ParallelSession> session;
  if (repose::dem::was_launched_in_parallel()) session.emplace(&argc, &argv);
  Request request;
  CLI::App app("Times the engine's steps on a case.");
  app.add_option("case", request.file, "case file")->required();
  app.add_option("steps", request.steps, "steps to time");
  app.add_option("--warm", request.warm, "steps before the clock starts");
  app.add_option("--time-step", request.time_step_s, "s; else as the case says");
  app.add_option("--open", request.opens, "wall to take away");
  app.add_option("--open-at", request.open_at_s, "s; when to take it away");
  app.add_option("--until", request.until_s, "s to simulate before the warm steps");
  CLI11_PARSE(app, argc, argv);
  try {
    measure(request);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
