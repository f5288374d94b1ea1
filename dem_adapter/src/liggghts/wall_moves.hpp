// Motions of walls as LIGGGHTS carries them out: in spans that begin and end at set times.
#pragma once

#include <string>
#include <vector>

#include "repose/scene/case.hpp"

namespace repose::dem_adapter::liggghts {

/// One movement of `fix move/mesh`; times count from the beginning of its stage.
struct MoveSpan {
  int motion = 0;  ///< index into Case::motions
  double begin_s = 0.0;
  double end_s = 0.0;  ///< infinite if it does not end
  std::string style;   ///< what follows the name of the mesh
};

/// The spans of the motions that count their time from this stage (the first: also from the run).
/// Throws InputError for what LIGGGHTS cannot do: an oscillation with a phase, and a span that
/// begins or ends in a stage that may be over by then, unless it is the last.
std::vector<MoveSpan> moves_of_stage(const scene::Case& scene, std::size_t stage);

}  // namespace repose::dem_adapter::liggghts
