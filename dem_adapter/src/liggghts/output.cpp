#include "output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <sstream>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter::liggghts {
namespace {

using scene::Vec3;

Row row_of(const std::string& words) {
  std::istringstream in(words);
  Row row;
  in >> row.step;
  for (std::string word; in >> word;) row.values.push_back(std::strtod(word.c_str(), nullptr));
  return row;
}

/// Its reasons as run.h5 has them.
std::string reason_of(std::string word) {
  std::replace(word.begin(), word.end(), '_', ' ');
  return word;
}

/// Takes the place of a position across periodic sides.
void wrap(const scene::Case& scene, Vec3& x) {
  const bool periodic[] = {scene.periodic.x, scene.periodic.y, scene.periodic.z};
  for (int k = 0; k < 3; ++k) {
    if (!periodic[k]) continue;
    const double period = scene.upper_m[k] - scene.lower_m[k];
    x[k] -= period * std::floor((x[k] - scene.lower_m[k]) / period);
    if (x[k] >= scene.upper_m[k]) x[k] = scene.lower_m[k];  // by rounding
  }
}

/// A frame as a snapshot, or what is wrong with it.
class Frames {
 public:
  Frames(const scene::Case& scene, const scene::Snapshot& start, double dt)
      : scene_(scene), start_(start), dt_(dt) {}

  std::optional<Defect> defect(const Frame& frame) const {
    if (frame.id.size() < start_.size())
      return Defect{Outcome::particles_lost,
                    fmt::format("{} of {} spheres are missing at {:.6g} s",
                                start_.size() - frame.id.size(), start_.size(), time_s(frame))};
    for (std::size_t i = 0; i < frame.id.size(); ++i) {
      const Vec3& x = frame.position[i];
      if (!x.allFinite() || !frame.velocity[i].allFinite())
        return Defect{Outcome::non_finite,
                      fmt::format("sphere {} has no finite position or velocity at {:.6g} s",
                                  start_.id[i], time_s(frame))};
      Vec3 inside = x;
      wrap(scene_, inside);
      if ((inside.array() < scene_.lower_m.array()).any() ||
          (inside.array() >= scene_.upper_m.array()).any())
        return Defect{Outcome::particles_lost,
                      fmt::format("sphere {} left the domain: it is at ({:.6g}, {:.6g}, {:.6g}) m "
                                  "at {:.6g} s",
                                  start_.id[i], x.x(), x.y(), x.z(), time_s(frame))};
    }
    return std::nullopt;
  }

  scene::Snapshot snapshot(const Frame& frame, const std::string& stage) const {
    scene::Snapshot s = start_;
    s.time_s = time_s(frame);
    s.stage = stage;
    s.position = frame.position;
    for (Vec3& x : s.position) wrap(scene_, x);
    s.velocity = frame.velocity;
    s.angular_velocity = frame.angular_velocity;
    return s;
  }

 private:
  double time_s(const Frame& frame) const { return static_cast<double>(frame.step) * dt_; }

  const scene::Case& scene_;
  const scene::Snapshot& start_;
  double dt_;
};

scene::SeriesRow series_row(const scene::Case& scene, const Row& row, double dt) {
  scene::SeriesRow result{.time_s = static_cast<double>(row.step) * dt};
  if (row.values.size() != 2 + scene::region_columns(scene).size())
    throw StorageError(
        fmt::format("the log of LIGGGHTS is damaged: its row of step {} has {} "
                    "values",
                    row.step, row.values.size()));
  result.kinetic_energy_j = row.values[0];
  result.contacts = std::llround(row.values[1]);
  result.region_mass_kg.assign(row.values.begin() + 2, row.values.end());
  return result;
}

}  // namespace

Log parse_log(const std::string& text) {
  Log log;
  std::istringstream lines(text);
  const std::string version = "LIGGGHTS-PUBLIC ";
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("@row ")) {
      log.rows.push_back(row_of(line.substr(5)));
    } else if (line.starts_with("@end ")) {
      std::istringstream in(line.substr(5));
      std::size_t stage = 0;
      StageEnd end;
      if (in >> stage >> end.step >> end.reason && stage == log.ends.size()) {
        end.reason = reason_of(end.reason);
        log.ends.push_back(end);
      }
    } else if (log.error.empty() && line.starts_with("ERROR")) {
      log.error = line;
    } else if (const auto at = line.find(version); at != std::string::npos) {
      const auto from = at + version.size();
      log = {.version = line.substr(from, line.find(',', from) - from)};
    }
  }
  return log;
}

FrameReader::FrameReader(const std::filesystem::path& file) : file_(file), in_(file) {}

std::optional<Frame> FrameReader::next() {
  std::string line;
  if (!std::getline(in_, line)) return std::nullopt;
  const auto damaged = [&]() -> StorageError {
    return StorageError(
        fmt::format("'{}' is damaged near \"{}\"", file_.string(), line.substr(0, 60)));
  };
  Frame frame;
  std::size_t count = 0;
  if (line != "ITEM: TIMESTEP" || !(in_ >> frame.step)) throw damaged();
  while (std::getline(in_, line) && !line.starts_with("ITEM: ATOMS"))
    if (line == "ITEM: NUMBER OF ATOMS" && !(in_ >> count)) throw damaged();
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::getline(in_, line)) throw damaged();
    const char* at = line.c_str();
    char* end = nullptr;
    frame.id.push_back(std::strtoll(at, &end, 10));
    for (auto* vectors : {&frame.position, &frame.velocity, &frame.angular_velocity}) {
      Vec3 v;
      for (int k = 0; k < 3; ++k) {
        at = end;
        v[k] = std::strtod(at, &end);  // reads nan as well
        if (end == at) throw damaged();
      }
      vectors->push_back(v);
    }
  }
  return frame;
}

double largest_overlap_ratio(const scene::Case& scene, const scene::Snapshot& s) {
  std::vector<std::size_t> order(s.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return s.position[a].x() < s.position[b].x(); });
  const double reach =
      s.size() == 0 ? 0.0 : 2.0 * *std::max_element(s.radius_m.begin(), s.radius_m.end());
  const Vec3 period = scene.upper_m - scene.lower_m;
  double largest = 0.0;
  const auto look = [&](std::size_t i, std::size_t j) {
    Vec3 way = s.position[j] - s.position[i];
    if (scene.periodic.x) way.x() -= period.x() * std::round(way.x() / period.x());
    if (scene.periodic.y) way.y() -= period.y() * std::round(way.y() / period.y());
    if (scene.periodic.z) way.z() -= period.z() * std::round(way.z() / period.z());
    const double overlap = s.radius_m[i] + s.radius_m[j] - way.norm();
    largest = std::max(largest, overlap / std::min(s.radius_m[i], s.radius_m[j]));
  };
  for (std::size_t a = 0; a < order.size(); ++a) {
    for (std::size_t b = a + 1; b < order.size(); ++b) {
      if (s.position[order[b]].x() - s.position[order[a]].x() > reach) break;
      look(order[a], order[b]);
    }
    if (!scene.periodic.x || s.position[order[a]].x() - scene.lower_m.x() > reach) continue;
    for (std::size_t b = order.size(); b-- > a + 1;) {  // behind the periodic side
      if (s.position[order[b]].x() < scene.upper_m.x() - reach) break;
      look(order[a], order[b]);
    }
  }
  return largest;
}

std::optional<Defect> write_run(const scene::Case& scene, const scene::Snapshot& start,
                                const Log& log, const std::filesystem::path& folder,
                                scene::RunSummary summary, scene::RunWriter& writer) {
  const double dt = summary.time_step_s;
  const Frames frames(scene, start, dt);
  for (const Row& row : log.rows) {
    for (const double value : row.values)
      if (!std::isfinite(value))
        return Defect{Outcome::non_finite,
                      fmt::format("the kinetic energy or a mass is not finite at {:.6g} s",
                                  static_cast<double>(row.step) * dt)};
    writer.add_row(series_row(scene, row, dt));
  }
  const auto write = [&](const Frame& frame, const std::string& stage) {
    const auto snapshot = frames.snapshot(frame, stage);
    summary.largest_overlap_ratio =
        std::max(summary.largest_overlap_ratio, largest_overlap_ratio(scene, snapshot));
    writer.write_snapshot(snapshot);
  };
  FrameReader periodic(folder / "frames.dump");
  auto frame = periodic.next();
  for (std::size_t s = 0; s < scene.stages.size(); ++s) {
    const auto& name = scene.stages[s].name;
    for (; frame && frame->step <= log.ends[s].step; frame = periodic.next()) {
      if (auto defect = frames.defect(*frame)) return defect;
      if (frame->step > 0 && frame->step < log.ends[s].step) write(*frame, name);
    }
    auto end = FrameReader(folder / fmt::format("stage_{}.dump", s)).next();
    if (!end) throw StorageError(fmt::format("LIGGGHTS left no stage_{}.dump", s));
    if (auto defect = frames.defect(*end)) return defect;
    write(*end, name);
    summary.stages.push_back(
        {name, static_cast<double>(log.ends[s].step) * dt, log.ends[s].reason});
    writer.log(fmt::format("stage \"{}\" ended at {:.6g} s: {}", name, summary.stages.back().time_s,
                           log.ends[s].reason));
  }
  summary.steps = log.ends.back().step;
  writer.finish(summary);
  return std::nullopt;
}

}  // namespace repose::dem_adapter::liggghts
