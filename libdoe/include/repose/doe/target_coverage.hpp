// Do the runs of a screening enclose what was measured, and if not, which way must the parameters'
// ranges be moved?
#pragma once

#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/doe/screening.hpp"

namespace repose::doe {

/// A measurement that the calibration is to meet.
struct Target {
  std::string response;
  double value = 0.0;
  double tolerance = 0.0;  ///< half the width of its interval, in units of the response; >= 0
};

struct CoverageOptions {
  /// A factor is significant for a response in this share of the repetitions; in (0, 1].
  double vote_share = 0.8;
  /// Ranges are extended by this share more than the gap asks for; >= 0.
  double margin = 0.25;
  /// A side is extended by so many half ranges at most; > 0. On a log scale, of the logarithm.
  double most_half_ranges = 1.0;
};

/// One target; vectors have one value a factor.
struct ResponseCoverage {
  enum class Position { inside, below, above };
  Target target;
  double lowest = 0.0, highest = 0.0;    ///< means of runs
  Position position = Position::inside;  ///< of the target to those
  /// From the nearest mean of a run to the far end of target +- tolerance; 0 inside.
  double gap = 0.0;
  /// More of the variance between runs is chance than parameters' doing (unbiased share below one
  /// half, or F test with p >= 0.01): this response cannot calibrate. False without repetitions.
  bool stochastic = false;
  std::vector<int> direction;  ///< move the factor up (1) or down (-1) to reach it; 0 neither
  /// Significant through second-order terms only: which way it must move, a main effect cannot say.
  std::vector<bool> undirected;
  double still_missing = 0.0;  ///< of the gap, after the proposed extension by the linear model
};

struct ProposedRange {
  std::string factor;
  double lower = 0.0, upper = 0.0;
  bool lower_extended = false, upper_extended = false;
  bool at_limit = false;             ///< a limit, or 0, kept it from being extended further
  std::vector<std::string> because;  ///< responses that ask for it
};

struct TargetCoverage {
  std::vector<ResponseCoverage> responses;  ///< in the order of the targets
  std::vector<ProposedRange> ranges;        ///< of all factors
};

/// Section 5.3.4 I of [Hadi2026] in numbers. A response y that lies outside the means of the runs
/// by a gap is met, to first order, if every factor j whose main effect is significant for it is
/// extended in the direction of that effect b_j (coded units) by the same delta: sum |b_j| delta =
/// gap (1 + margin). A factor that meets its limit leaves the rest to the others. `ranges` are
/// those of the screening, in the order of its factors; `limits` what is physically possible, by
/// name, for some or all of them. A factor without limits that was screened at values >= 0 does not
/// become negative. Throws InputError for an unknown response or factor, a range that lies outside
/// its limits, or an option out of range.
TargetCoverage cover_targets(const Screening& screening, const std::vector<Target>& targets,
                             const ParameterSpace& ranges,
                             const std::vector<Parameter>& limits = {},
                             const CoverageOptions& options = {});

}  // namespace repose::doe
