// Coverage of targets by screening runs.
#include "repose/doe/target_coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::doe {
namespace {

using Position = ResponseCoverage::Position;

/// Level `coded` of a parameter, which may lie beyond [-1, 1].
double natural(const Parameter& parameter, double coded) {
  const double share = 0.5 * (coded + 1.0);
  if (parameter.scale == Scale::log)
    return parameter.lower * std::pow(parameter.upper / parameter.lower, share);
  return parameter.lower + share * (parameter.upper - parameter.lower);
}

double coded(const Parameter& parameter, double value) {
  if (parameter.scale == Scale::log)
    return 2.0 * std::log(value / parameter.lower) / std::log(parameter.upper / parameter.lower) -
           1.0;
  return 2.0 * (value - parameter.lower) / (parameter.upper - parameter.lower) - 1.0;
}

/// How far each side of a factor may be extended, in half ranges.
struct Room {
  double below = 0.0, above = 0.0;
  bool below_by_limit = false, above_by_limit = false;
};

Room room_of(const Parameter& parameter, const std::vector<Parameter>& limits,
             const CoverageOptions& options) {
  Room room{options.most_half_ranges, options.most_half_ranges};
  const auto limit = std::find_if(limits.begin(), limits.end(),
                                  [&](const Parameter& p) { return p.name == parameter.name; });
  if (limit == limits.end()) {
    if (parameter.scale == Scale::linear && parameter.lower >= 0.0) {
      const double to_zero = -1.0 - coded(parameter, 0.0);
      room.below_by_limit = to_zero < room.below;
      room.below = std::min(room.below, to_zero);
    }
    return room;
  }
  if (limit->lower > parameter.lower || limit->upper < parameter.upper)
    throw InputError(fmt::format(
        "target coverage: {} was screened from {} to {}, but its limits are {} to {}; widen them",
        parameter.name, shortest(parameter.lower), shortest(parameter.upper),
        shortest(limit->lower), shortest(limit->upper)));
  const bool reaches_zero = parameter.scale == Scale::log && !(limit->lower > 0.0);
  const double below = reaches_zero ? std::numeric_limits<double>::infinity()
                                    : -1.0 - coded(parameter, limit->lower);
  const double above = coded(parameter, limit->upper) - 1.0;
  room.below_by_limit = below < room.below;
  room.above_by_limit = above < room.above;
  room.below = std::min(room.below, below);
  room.above = std::min(room.above, above);
  return room;
}

const ResponseScreening& response_named(const Screening& screening, const std::string& name) {
  std::vector<std::string> names;
  for (const ResponseScreening& response : screening.responses) {
    if (response.response == name) return response;
    names.push_back(response.response);
  }
  throw InputError(
      fmt::format("target coverage: no response is called {}; there are {}", name, listed(names)));
}

void place(ResponseCoverage& coverage, const ResponseScreening& response) {
  coverage.lowest = std::numeric_limits<double>::infinity();
  coverage.highest = -coverage.lowest;
  for (const double mean : response.run_means) {  // NaN for runs without a value
    coverage.lowest = std::fmin(coverage.lowest, mean);
    coverage.highest = std::fmax(coverage.highest, mean);
  }
  const Target& target = coverage.target;
  if (target.value > coverage.highest) {
    coverage.position = Position::above;
    coverage.gap = target.value + target.tolerance - coverage.highest;
  } else if (target.value < coverage.lowest) {
    coverage.position = Position::below;
    coverage.gap = coverage.lowest - (target.value - target.tolerance);
  }
  const VarianceDecomposition& variance = response.variance;
  coverage.stochastic =
      !std::isnan(variance.p_value) && (variance.p_value >= 0.01 || variance.unbiased_share < 0.5);
}

/// delta with sum_j |b_j| min(delta, room_j) = needed; the largest room if that is not enough.
double common_extension(const std::vector<double>& slopes, const std::vector<double>& room,
                        double needed) {
  std::vector<double> ends = room;
  std::sort(ends.begin(), ends.end());
  double reached = 0.0, from = 0.0;
  for (const double end : ends) {
    double slope = 0.0;
    for (std::size_t j = 0; j < room.size(); ++j)
      if (room[j] > from) slope += slopes[j];
    if (reached + slope * (end - from) >= needed && slope > 0.0)
      return from + (needed - reached) / slope;
    reached += slope * (end - from);
    from = end;
  }
  return from;
}

void check_options(const CoverageOptions& options) {
  const auto refuse = [](const char* what, double value, const char* allowed) {
    throw InputError(fmt::format("target coverage: {} is {}; it must be {}", what, value, allowed));
  };
  if (!(options.vote_share > 0.0 && options.vote_share <= 1.0))
    refuse("the share of votes", options.vote_share, "in (0, 1]");
  if (!(options.margin >= 0.0 && std::isfinite(options.margin)))
    refuse("the margin", options.margin, "0 or more");
  if (!(options.most_half_ranges > 0.0 && std::isfinite(options.most_half_ranges)))
    refuse("the largest extension", options.most_half_ranges, "above 0 half ranges");
}

/// Extends the ranges of the factors that are significant for a target outside the runs.
void extend(ResponseCoverage& coverage, const ResponseScreening& response,
            const std::vector<bool>& significant, const std::vector<bool>& directed,
            const std::vector<Parameter>& parameters, const std::vector<Room>& rooms, double margin,
            std::vector<ProposedRange>& ranges) {
  const double way = coverage.position == Position::above ? 1.0 : -1.0;
  std::vector<double> slopes, room;
  std::vector<std::size_t> factors;
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const double effect = response.effect(static_cast<Eigen::Index>(j));
    coverage.undirected[j] = significant[j] && !directed[j];
    if (!directed[j] || effect == 0.0) continue;
    coverage.direction[j] = way * effect > 0.0 ? 1 : -1;
    factors.push_back(j);
    slopes.push_back(std::abs(effect));
    room.push_back(coverage.direction[j] > 0 ? rooms[j].above : rooms[j].below);
  }
  const double delta = common_extension(slopes, room, coverage.gap * (1.0 + margin));
  coverage.still_missing = coverage.gap;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::size_t j = factors[i];
    const bool up = coverage.direction[j] > 0;
    const double extension = std::min(delta, room[i]);
    coverage.still_missing -= slopes[i] * extension;
    ProposedRange& range = ranges[j];
    range.because.push_back(coverage.target.response);
    if ((up ? rooms[j].above_by_limit : rooms[j].below_by_limit) && delta >= room[i])
      range.at_limit = true;
    if (up)
      range.upper = std::max(range.upper, natural(parameters[j], 1.0 + extension));
    else
      range.lower = std::min(range.lower, natural(parameters[j], -1.0 - extension));
  }
  coverage.still_missing = std::max(0.0, coverage.still_missing);
}

}  // namespace

TargetCoverage cover_targets(const Screening& screening, const std::vector<Target>& targets,
                             const ParameterSpace& ranges, const std::vector<Parameter>& limits,
                             const CoverageOptions& options) {
  check_options(options);
  const std::vector<Parameter>& parameters = ranges.parameters();
  if (ranges.names() != screening.factors)
    throw InputError(fmt::format("target coverage: ranges of {} for a screening of {}",
                                 listed(ranges.names()), listed(screening.factors)));
  for (const Parameter& limit : limits)
    if (std::find(screening.factors.begin(), screening.factors.end(), limit.name) ==
        screening.factors.end()) {
      const std::string near = closest_name(limit.name, screening.factors);
      throw InputError(fmt::format("target coverage: limits of {}, which is no factor{}",
                                   limit.name,
                                   near.empty() ? "; the factors are " + listed(screening.factors)
                                                : "; did you mean " + near + "?"));
    }
  std::vector<Room> rooms;
  TargetCoverage result;
  for (const Parameter& parameter : parameters) {
    rooms.push_back(room_of(parameter, limits, options));
    result.ranges.push_back(
        {.factor = parameter.name, .lower = parameter.lower, .upper = parameter.upper});
  }
  for (const Target& target : targets) {
    const ResponseScreening& response = response_named(screening, target.response);
    if (!std::isfinite(target.value) ||
        !(target.tolerance >= 0.0 && std::isfinite(target.tolerance)))
      throw InputError(
          fmt::format("target coverage: the target of {} is {} +- {}; it must be "
                      "finite, the tolerance 0 or more",
                      target.response, target.value, target.tolerance));
    ResponseCoverage coverage{.target = target,
                              .direction = std::vector<int>(parameters.size(), 0),
                              .undirected = std::vector<bool>(parameters.size(), false)};
    place(coverage, response);
    if (coverage.position != Position::inside)
      extend(coverage, response, vote({response.count}, screening.repetitions, options.vote_share),
             vote({response.main_effect_count}, screening.repetitions, options.vote_share),
             parameters, rooms, options.margin, result.ranges);
    result.responses.push_back(std::move(coverage));
  }
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    result.ranges[j].lower_extended = result.ranges[j].lower < parameters[j].lower;
    result.ranges[j].upper_extended = result.ranges[j].upper > parameters[j].upper;
  }
  return result;
}

}  // namespace repose::doe
