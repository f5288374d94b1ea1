#include "wall_moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter::liggghts {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

std::string words(const scene::Vec3& v) {
  return fmt::format("{} {} {}", shortest(v.x()), shortest(v.y()), shortest(v.z()));
}

/// Spans of one motion from its start on, times counted from there.
struct Spans {
  std::vector<MoveSpan> operator()(const scene::Translation& t) const {
    return {{.end_s = kNever, .style = "linear " + words(t.velocity_m_s)}};
  }
  std::vector<MoveSpan> operator()(const scene::Rotation& r) const {
    if (r.rate_rad_s == 0.0) return {};
    const scene::Vec3 axis = std::copysign(1.0, r.rate_rad_s) * r.axis.normalized();
    return {
        {.end_s = kNever,
         .style = fmt::format("rotate origin {} axis {} period {}", words(r.centre), words(axis),
                              shortest(2.0 * std::numbers::pi / std::abs(r.rate_rad_s)))}};
  }
  std::vector<MoveSpan> operator()(const scene::Oscillation& o) const {
    if (o.phase_rad != 0.0)
      throw InputError(
          fmt::format("phase_rad = {}: the engine liggghts oscillates walls from phase 0 only",
                      shortest(o.phase_rad)));
    return {{.end_s = kNever,
             .style = fmt::format("wiggle amplitude {} period {}", words(o.amplitude_m),
                                  shortest(1.0 / o.frequency_hz))}};
  }
  std::vector<MoveSpan> operator()(const scene::TimeTable& table) const {
    if (!table.displacements_m.front().isZero(0.0))
      throw InputError(
          "the first displacement of a motion is not 0: the engine liggghts begins where the wall "
          "was drawn");
    std::vector<MoveSpan> spans;
    for (std::size_t i = 0; i + 1 < table.times_s.size(); ++i) {
      const double duration = table.times_s[i + 1] - table.times_s[i];
      const scene::Vec3 way = table.displacements_m[i + 1] - table.displacements_m[i];
      if (way.isZero(0.0)) continue;
      spans.push_back({.begin_s = table.times_s[i],
                       .end_s = table.times_s[i + 1],
                       .style = "linear " + words(way / duration)});
    }
    return spans;
  }
};

/// When a stage is certainly not over yet.
double certain_s(const scene::Stage& stage) {
  return stage.at_rest || stage.flow_ends ? stage.minimum_s : stage.duration_s;
}

}  // namespace

std::vector<MoveSpan> moves_of_stage(const scene::Case& scene, std::size_t s) {
  const scene::Stage& stage = scene.stages[s];
  const bool is_last = s + 1 == scene.stages.size();
  std::vector<MoveSpan> all;
  for (std::size_t m = 0; m < scene.motions.size(); ++m) {
    const scene::Motion& motion = scene.motions[m];
    if (motion.stage != stage.name && !(motion.stage.empty() && s == 0)) continue;
    for (auto span : std::visit(Spans{}, motion.path)) {
      span.motion = static_cast<int>(m);
      span.begin_s += motion.start_s;
      span.end_s = std::min(span.end_s + motion.start_s, motion.end_s);
      if (span.begin_s >= span.end_s) continue;
      for (const double time : {span.begin_s, span.end_s})
        if (std::isfinite(time) && time > 0.0 && time > certain_s(stage) && !is_last)
          throw InputError(fmt::format(
              "a motion begins or ends {} s after stage \"{}\" began, which may be over by then; "
              "the engine liggghts wants that within minimum_s or duration_s, or in the last stage",
              shortest(time), stage.name));
      all.push_back(std::move(span));
    }
  }
  return all;
}

}  // namespace repose::dem_adapter::liggghts
