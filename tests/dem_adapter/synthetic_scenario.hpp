// A scenario and an engine without particles: KPIs are known functions of the parameters plus
// seeded noise, so that calibration can be tested against its answer in a second. They stand beside
// the real ones.
#pragma once

#include <atomic>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/scenario.hpp"

namespace repose::test {

/// Parameters a, b, c, d, e in [0, 1]; only a and b matter.
struct SyntheticScenario {
  static std::vector<double> kpis(double a, double b) {
    return {30.0 + 20.0 * a - 6.0 * a * a, 25.0 + 10.0 * b + 3.0 * a * b, 0.9 - 0.1 * a - 0.05 * b};
  }
  std::string name() const { return "synthetic"; }
  std::vector<std::string> parameter_names() const { return {"a", "b", "c", "d", "e"}; }
  std::vector<std::string> kpi_names() const { return {"first", "second", "third"}; }
  scene::Case make_case(const ParameterValues& values, std::uint64_t seed) const {
    scene::Case c;
    c.seed = seed;
    c.lower_m = {0, 0, 0};
    c.upper_m = {1, 1, 1};
    c.materials = {{"m", 2500, 1e7, 0.25}};
    c.pairs = {{.first = "m",
                .second = "m",
                .restitution = 0.5,
                .mu_s = values.at("a"),
                .mu_r = values.at("b")}};
    // The rest travels as the particle's place, so that different parameters are different cases.
    c.particles = {{.material = "m",
                    .position = {0.2 + 0.5 * values.at("c"), 0.2 + 0.5 * values.at("d"),
                                 0.2 + 0.5 * values.at("e")},
                    .radius_m = 0.01}};
    c.stages = {{.name = "wait", .opens = {}, .duration_s = 1e-3, .at_rest = {}, .flow_ends = {}}};
    return c;
  }
  dem_adapter::Measurement measure(const scene::Run&) const { return {}; }
};

/// Writes the KPIs of SyntheticScenario with normal noise of `noise` times (1, 1, 0.01).
/// Counts its runs.
class SyntheticEngine {
 public:
  explicit SyntheticEngine(double noise) : noise_(noise) {}
  std::string name() const { return "synthetic 1"; }
  dem_adapter::EngineExit run(const dem_adapter::EngineJob& job) const {
    if (++*runs_ % stop_every_ == 0 && stop_flag_ != nullptr)
      *stop_flag_ = dem_adapter::Stop::when_runs_end;
    const auto c = scene::read_case(job.directory / "case.toml");
    const double a = c.pairs.front().mu_s, b = c.pairs.front().mu_r;
    if (fails_above_ < a)
      return {.status = dem_adapter::EngineStatus::failed,
              .failure = dem_adapter::Outcome::crash,
              .message = "it broke",
              .resources = {}};
    auto values = SyntheticScenario::kpis(a, b);
    RandomStream random(c.seed);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] += noise_ * (i == 2 ? 0.01 : 1.0) * random.normal();
    std::filesystem::create_directories(job.directory / "output");
    std::ofstream out(job.directory / "output" / "kpis.txt");
    out.precision(17);
    for (const double v : values) out << v << '\n';
    return {.status = dem_adapter::EngineStatus::finished,
            .message = "",
            .resources = {.wall_time_s = 0.01}};
  }
  static dem_adapter::Measure measure() {
    return {"synthetic", [](const std::filesystem::path& output) {
              dem_adapter::Measurement m;
              std::ifstream in(output / "kpis.txt");
              for (const char* name : {"first", "second", "third"}) in >> m.kpis[name];
              return m;
            }};
  }
  int runs() const { return *runs_; }
  SyntheticEngine& failing_above(double a) {
    fails_above_ = a;
    return *this;
  }

  /// Raises the flag at every n-th run, as a user's Ctrl-C would.
  SyntheticEngine& stopping_every(int n, std::atomic<dem_adapter::Stop>* flag) {
    stop_every_ = n;
    stop_flag_ = flag;
    return *this;
  }

 private:
  int stop_every_ = 1000000;
  std::atomic<dem_adapter::Stop>* stop_flag_ = nullptr;
  double noise_;
  double fails_above_ = 1e9;
  std::shared_ptr<std::atomic<int>> runs_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace repose::test
