// A whole run: a case in, a run folder out.
#pragma once

#include <filesystem>

#include "repose/base/progress.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem {

/// Runs all stages of a case and writes its run folder (see run_output.hpp). Criteria that end a
/// stage are looked at with each row of the series. `progress` is told the simulated time and the
/// latest at which the run may end, which comes closer when a stage ends early; what it throws ends
/// the run, and the folder then holds closed parts but no run.h5. Throws InputError before the
/// first step, SimulationError, StorageError.
scene::RunSummary run_case(const scene::Case& scene, const std::filesystem::path& run_dir,
                           const ProgressCallback& progress = {});

}  // namespace repose::dem
