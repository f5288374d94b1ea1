// One requirement on the engine's physics, what came out, and the verdict.
#pragma once

#include <string>
#include <vector>

namespace repose::physics {

enum class Demand {
  near,      ///< |result - reference| <= tolerance
  at_most,   ///< result <= reference + tolerance
  at_least,  ///< result >= reference - tolerance
  report     ///< no verdict: a figure to know
};

struct Check {
  std::string requirement;  ///< a sentence
  double result = 0.0;
  double reference = 0.0;
  double tolerance = 0.0;
  std::string unit{};
  Demand demand = Demand::near;

  bool passed() const;
};

/// How far to go: for CI, or for the validation report.
enum class Extent { quick, full };

/// Checks of one subject.
struct Group {
  std::string id;
  std::string title;
  std::string note;  ///< reference, setup and where the tolerance comes from
  std::vector<Check> (*run)(Extent);
};

/// In the order of the report.
const std::vector<Group>& all_groups();

std::vector<Check> chung_ooi(Extent);
std::vector<Check> oblique_impacts(Extent);
std::vector<Check> restitution(Extent);
std::vector<Check> sliding_and_rolling(Extent);
std::vector<Check> rotating_frame(Extent);
std::vector<Check> angular_momentum(Extent);
std::vector<Check> elastic_gas(Extent);
std::vector<Check> time_step_order(Extent);
std::vector<Check> size_ratio(Extent);
std::vector<Check> clumps(Extent);
std::vector<Check> meshes(Extent);
std::vector<Check> drums(Extent);
std::vector<Check> beverloo(Extent);
std::vector<Check> angle_of_repose(Extent);

}  // namespace repose::physics
