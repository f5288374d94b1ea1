// Time steps of the bundled engine on the quick draw-down rig, filled and at rest.
#include <benchmark/benchmark.h>

#include "repose/dem/simulation.hpp"
#include "repose/scene/case.hpp"

namespace {

void quick_drawdown(benchmark::State& state) {
  const auto scene = repose::scene::read_case(REPOSE_SOURCE_DIR "/tests/data/quick_drawdown.toml");
  repose::dem::Simulation simulation(scene);
  while (simulation.time_s() < 0.3) simulation.step(100);
  if (state.range(0) == 1) {
    simulation.open("gate");
    while (simulation.time_s() < 0.6) simulation.step(100);
  }
  constexpr int kSteps = 100;
  for (auto _ : state) simulation.step(kSteps);
  state.counters["sphere_steps"] = benchmark::Counter(
      static_cast<double>(simulation.size()) * kSteps * static_cast<double>(state.iterations()),
      benchmark::Counter::kIsRate);
}
BENCHMARK(quick_drawdown)->Arg(0)->Arg(1)->ArgName("flowing")->Unit(benchmark::kMillisecond);

}  // namespace
