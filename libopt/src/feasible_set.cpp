// Linear constraints, ties and whole numbers.
#include "repose/opt/feasible_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

/// Of the size of the terms: a constraint broken by less is broken by rounding.
constexpr double kRounding = 1e-12;

std::string name_of(const FeasibleSet& set, std::size_t i) {
  return set.inequalities[i].name.empty() ? fmt::format("constraint {}", i + 1)
                                          : "constraint " + set.inequalities[i].name;
}

/// sum |a_k| (upper_k - lower_k): how much a . x varies over the box.
double range_of(const LinearInequality& inequality, const Bounds& bounds) {
  return inequality.coefficients.cwiseAbs().dot(bounds.upper - bounds.lower);
}

bool is_whole(const FeasibleSet& set, Eigen::Index k) {
  return std::find(set.whole.begin(), set.whole.end(), k) != set.whole.end();
}

void check_whole(const FeasibleSet& set) {
  const Eigen::Index d = set.bounds.lower.size();
  for (const Eigen::Index k : set.whole)
    if (k < 0 || k >= d)
      throw InputError(
          fmt::format("coordinate {} is to be a whole number; there are {}", k + 1, d));
}

void check_tie(const FeasibleSet& set, const LinearTie& tie) {
  const Eigen::Index d = set.bounds.lower.size();
  for (const Eigen::Index k : {tie.follower, tie.leader})
    if (k < 0 || k >= d)
      throw InputError(fmt::format("a tie names coordinate {}; there are {}", k + 1, d));
  const auto refuse = [&tie](const std::string& why) {
    throw InputError(fmt::format("coordinate {} is tied to coordinate {}, {}", tie.follower + 1,
                                 tie.leader + 1, why));
  };
  if (tie.follower == tie.leader) refuse("which is itself");
  if (!std::isfinite(tie.ratio) || !std::isfinite(tie.offset) || tie.ratio == 0.0)
    refuse(
        fmt::format("offset + ratio x = {} + {} x; both must be finite and the ratio not 0 (to "
                    "fix a coordinate give it equal bounds)",
                    tie.offset, tie.ratio));
  const auto follows = [&set](Eigen::Index k) {
    return std::count_if(set.ties.begin(), set.ties.end(),
                         [k](const LinearTie& other) { return other.follower == k; });
  };
  if (follows(tie.follower) > 1) refuse("and follows another one too; one tie is allowed");
  if (follows(tie.leader) > 0) refuse("which follows another one; tie both to that one");
  const bool stays_whole = is_whole(set, tie.leader) && tie.ratio == std::round(tie.ratio) &&
                           tie.offset == std::round(tie.offset);
  if (is_whole(set, tie.follower) && !stays_whole)
    refuse(
        fmt::format("as {} + {} x, which need not be whole as it is to be; make the leader, the "
                    "offset and the ratio whole",
                    tie.offset, tie.ratio));
}

/// The values of the leader that keep the follower within its bounds.
std::pair<double, double> leader_range(const LinearTie& tie, const Bounds& bounds) {
  const double a = (bounds.lower[tie.follower] - tie.offset) / tie.ratio;
  const double b = (bounds.upper[tie.follower] - tie.offset) / tie.ratio;
  return std::minmax(a, b);
}

void narrow_leader(Bounds& bounds, const LinearTie& tie, const Bounds& all) {
  const auto [least, most] = leader_range(tie, all);
  bounds.lower[tie.leader] = std::max(bounds.lower[tie.leader], least);
  bounds.upper[tie.leader] = std::min(bounds.upper[tie.leader], most);
}

void check_leaders(const FeasibleSet& set) {
  Bounds left = set.bounds;
  for (const LinearTie& tie : set.ties) {
    const Eigen::Index k = tie.leader;
    const double lower = left.lower[k], upper = left.upper[k];
    narrow_leader(left, tie, set.bounds);
    if (left.lower[k] <= left.upper[k]) continue;
    const auto [least, most] = leader_range(tie, set.bounds);
    throw InputError(fmt::format(
        "coordinate {} is tied to coordinate {} as {} + {} x and lies in [{}, {}], so that the "
        "latter must lie in [{}, {}]; its own bounds and earlier ties leave only [{}, {}]",
        tie.follower + 1, k + 1, tie.offset, tie.ratio, set.bounds.lower[tie.follower],
        set.bounds.upper[tie.follower], least, most, lower, upper));
  }
}

void check_inequality(const FeasibleSet& set, std::size_t i) {
  const LinearInequality& inequality = set.inequalities[i];
  const Eigen::Index d = set.bounds.lower.size();
  const Vector& a = inequality.coefficients;
  if (a.size() != d || !a.allFinite() || !std::isfinite(inequality.bound))
    throw InputError(
        fmt::format("{} has {} coefficients; {} finite ones and a finite bound are "
                    "needed",
                    name_of(set, i), a.size(), d));
  // over the coordinates that follow no other: a leader moves with its followers
  const Bounds bounds = narrowed_bounds(set);
  Vector effective = a;
  double least = 0.0;
  for (const LinearTie& tie : set.ties) {
    effective[tie.leader] += tie.ratio * a[tie.follower];
    effective[tie.follower] = 0.0;
    least += tie.offset * a[tie.follower];
  }
  const Vector lowest = (effective.array() > 0.0).select(bounds.lower, bounds.upper);
  least += lowest.dot(effective);
  // of the size of its terms, as violation() has it, and of the box
  const double size = effective.cwiseAbs().dot(lowest.cwiseAbs()) + std::abs(inequality.bound) +
                      range_of(inequality, set.bounds);
  if (least > inequality.bound + kRounding * size)
    throw InputError(fmt::format("{}: no point of the box is below {}; the smallest value is {}",
                                 name_of(set, i), inequality.bound, least));
}

}  // namespace

void check_feasible_set(const FeasibleSet& set) {
  check_bounds(set.bounds);
  check_whole(set);
  for (const LinearTie& tie : set.ties) check_tie(set, tie);
  check_leaders(set);
  const Bounds bounds = narrowed_bounds(set);
  for (const Eigen::Index k : set.whole)
    if (std::ceil(bounds.lower[k]) > std::floor(bounds.upper[k]))
      throw InputError(fmt::format("coordinate {} lies in [{}, {}], which holds no whole number",
                                   k + 1, bounds.lower[k], bounds.upper[k]));
  for (std::size_t i = 0; i < set.inequalities.size(); ++i) check_inequality(set, i);
}

std::vector<Eigen::Index> free_coordinates(const FeasibleSet& set) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < set.bounds.lower.size(); ++k)
    if (std::none_of(set.ties.begin(), set.ties.end(),
                     [k](const LinearTie& tie) { return tie.follower == k; }))
      free.push_back(k);
  return free;
}

Bounds narrowed_bounds(const FeasibleSet& set) {
  Bounds bounds = set.bounds;
  for (const LinearTie& tie : set.ties) narrow_leader(bounds, tie, set.bounds);
  return bounds;
}

Vector rounded(const Vector& x, const FeasibleSet& set) {
  const Bounds bounds = set.ties.empty() ? set.bounds : narrowed_bounds(set);
  Vector result = project(x, bounds);
  for (const Eigen::Index k : set.whole)
    result[k] =
        std::clamp(std::round(result[k]), std::ceil(bounds.lower[k]), std::floor(bounds.upper[k]));
  for (const LinearTie& tie : set.ties)  // within the bounds whatever rounding does
    result[tie.follower] =
        std::clamp(tie.offset + tie.ratio * result[tie.leader], set.bounds.lower[tie.follower],
                   set.bounds.upper[tie.follower]);
  return result;
}

double violation(const Vector& x, const FeasibleSet& set) {
  double sum = 0.0;
  for (const LinearInequality& inequality : set.inequalities) {
    const double excess = inequality.coefficients.dot(x) - inequality.bound;
    const double size =
        inequality.coefficients.cwiseAbs().dot(x.cwiseAbs()) + std::abs(inequality.bound);
    if (excess > kRounding * size)
      sum += excess / std::max(range_of(inequality, set.bounds), 1e-300);
  }
  for (const LinearTie& tie : set.ties) {
    const double followed = tie.ratio * x[tie.leader];
    const double off = std::abs(x[tie.follower] - tie.offset - followed);
    const double size = std::abs(x[tie.follower]) + std::abs(tie.offset) + std::abs(followed);
    const double range = set.bounds.upper[tie.follower] - set.bounds.lower[tie.follower];
    if (off > kRounding * size) sum += off / std::max(range, 1e-300);
  }
  return sum;
}

}  // namespace repose::opt
