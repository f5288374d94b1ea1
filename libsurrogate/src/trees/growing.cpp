#include "growing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "repose/base/error.hpp"

namespace repose::surrogate::trees {
namespace {

Count count_or_none(std::optional<Eigen::Index> limit) {
  constexpr Eigen::Index kNone = std::numeric_limits<std::int32_t>::max();
  return static_cast<Count>(std::min(limit.value_or(kNone), kNone));
}

void check_at_least_one(std::optional<Eigen::Index> value, const char* what) {
  if (value && *value < 1)
    throw InputError(fmt::format("{} of a tree is {}; it must be at least 1", what, *value));
}

}  // namespace

void check_options(const TreeOptions& options, Eigen::Index inputs) {
  check_at_least_one(options.minimum_leaf, "the minimum leaf");
  check_at_least_one(options.maximum_splits, "the maximum number of splits");
  check_at_least_one(options.maximum_depth, "the maximum depth");
  if (options.predictors && (*options.predictors < 1 || *options.predictors > inputs))
    throw InputError(
        fmt::format("{} predictors are to be drawn for a split; there are {}: give 1 to "
                    "that many",
                    *options.predictors, inputs));
}

Limits limits_of(const TreeOptions& options, const Columns& columns) {
  return {
      .minimum_leaf = count_or_none(options.minimum_leaf),
      .maximum_splits = count_or_none(options.maximum_splits),
      .maximum_depth = count_or_none(options.maximum_depth),
      .predictors = std::min(
          static_cast<std::size_t>(options.predictors.value_or(columns.inputs())), columns.size())};
}

std::vector<double> weights_of(const TrainingSet& data) {
  if (data.weights.size() > 0) return {data.weights.begin(), data.weights.end()};
  return std::vector<double>(static_cast<std::size_t>(data.rows()), 1.0);
}

std::string describe(const TreeOptions& options, Eigen::Index inputs) {
  std::string text = fmt::format(", minimum leaf {}", options.minimum_leaf);
  if (options.maximum_splits) text += fmt::format(", at most {} splits", *options.maximum_splits);
  if (options.maximum_depth) text += fmt::format(", at most {} deep", *options.maximum_depth);
  if (options.predictors)
    text += fmt::format(", {} of {} predictors a split", *options.predictors, inputs);
  return text;
}

}  // namespace repose::surrogate::trees
