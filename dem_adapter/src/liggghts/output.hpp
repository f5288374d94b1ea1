// What LIGGGHTS leaves behind, as a run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/outcome.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter::liggghts {

/// What the script had it say, see script_text().
struct Row {
  std::int64_t step = 0;
  std::vector<double> values;  ///< kinetic energy, contacts, masses
};
struct StageEnd {
  std::int64_t step = 0;
  std::string reason;
};
struct Log {
  std::string version;  ///< "3.8.0"; empty if it did not come to say it
  std::vector<Row> rows;
  std::vector<StageEnd> ends;
  std::string error;  ///< its own words, the first of them
};
/// Of the last start: a run that was killed by others is begun anew and goes on in the same log.
Log parse_log(const std::string& text);

/// Particles at one step, by ascending id.
struct Frame {
  std::int64_t step = 0;
  std::vector<std::int64_t> id;
  std::vector<scene::Vec3> position, velocity, angular_velocity;
};
/// Frames of a dump, one by one. Throws StorageError if the file is damaged.
class FrameReader {
 public:
  explicit FrameReader(const std::filesystem::path& file);
  std::optional<Frame> next();

 private:
  std::filesystem::path file_;
  std::ifstream in_;
};

/// A reason why the output cannot be a run.
struct Defect {
  Outcome outcome;
  std::string message;
};

/// Writes the run folder from `log` and the dumps in `folder`; `start` holds all particles as they
/// began, `summary` what is known beforehand. Nothing is written to the end if a particle is
/// missing, has left the domain or has no finite position: that is returned.
std::optional<Defect> write_run(const scene::Case& scene, const scene::Snapshot& start,
                                const Log& log, const std::filesystem::path& folder,
                                scene::RunSummary summary, scene::RunWriter& writer);

/// The largest overlap of two spheres over the smaller radius, 0 if none touch. Cost: n times those
/// within a largest diameter along x.
double largest_overlap_ratio(const scene::Case& scene, const scene::Snapshot& snapshot);

}  // namespace repose::dem_adapter::liggghts
