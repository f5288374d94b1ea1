// The engine LIGGGHTS 3.8, of which Debian's package is the reference.
#pragma once

#include <filesystem>
#include <string>

#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/executor.hpp"

namespace repose::dem_adapter {

/// Empty: beside the running program, then on PATH.
struct LiggghtsPrograms {
  std::filesystem::path liggghts{};
  std::filesystem::path mpirun{};      ///< starts several ranks
  std::filesystem::path repose_dem{};  ///< places the particles
  std::filesystem::path stdbuf{};
};

/// Runs cases of spheres. repose-dem places the particles, so that a seed gives the packing that
/// the bundled engine begins with, and the time step; LIGGGHTS gets a script, a data file and STL
/// files in output/liggghts, which stay; what it says and dumps becomes run.h5. Not in run.h5:
/// forces on walls, contacts by pair of materials, overlaps but those at snapshots. Runs begin
/// anew: it has no checkpoints. What it says always goes to the log. docs/how-to/engines.md says
/// what it cannot do.
class LiggghtsEngine {
 public:
  /// Throws StorageError, naming the Debian package, if a program is missing.
  explicit LiggghtsEngine(LiggghtsPrograms programs = {}, Executor executor = LocalExecutor());
  /// With the content of program and library, and of repose-dem.
  std::string name() const { return name_; }
  /// Throws InputError for a case that it cannot do, and as BundledEngine::run() for one that
  /// cannot be placed.
  EngineExit run(const EngineJob& job) const;

 private:
  EngineExit place(const EngineJob& job, const std::filesystem::path& placed) const;
  Command command_of(const EngineJob& job, const std::filesystem::path& folder) const;

  LiggghtsPrograms programs_;
  Executor executor_;
  std::string name_;
};

}  // namespace repose::dem_adapter
