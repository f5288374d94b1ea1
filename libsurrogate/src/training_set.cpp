#include "repose/surrogate/training_set.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

void check_length(std::size_t length, Eigen::Index rows, const char* what) {
  if (length != 0 && static_cast<Eigen::Index>(length) != rows)
    throw InputError(
        fmt::format("{} {} for {} rows; there must be one for each", length, what, rows));
}

template <class Values>
Values selected(const Values& values, std::span<const Eigen::Index> rows) {
  Values result;
  if (values.empty()) return result;
  for (const Eigen::Index i : rows) result.push_back(values[static_cast<std::size_t>(i)]);
  return result;
}

}  // namespace

void check(const TrainingSet& data) {
  const Eigen::Index n = data.rows();
  if (data.y.size() != n)
    throw InputError(fmt::format("{} rows of inputs for {} responses; there must be one for each",
                                 n, data.y.size()));
  if (n == 0) throw InputError("no rows to fit a model to");
  if (data.inputs.empty()) throw InputError("no inputs to predict from");
  check_inputs(data.inputs);
  check_points(data.inputs, data.x);
  for (Eigen::Index i = 0; i < n; ++i)
    if (!std::isfinite(data.y[i]))
      throw InputError(fmt::format(
          "row {}, response is {}; it must be finite: drop or repair the row", i + 1, data.y[i]));
  check_length(static_cast<std::size_t>(data.weights.size()), n, "weights");
  check_length(data.groups.size(), n, "groups");
  check_length(data.replicates.size(), n, "numbers of replicated points");
  for (Eigen::Index i = 0; i < data.weights.size(); ++i)
    if (!(data.weights[i] > 0.0) || !std::isfinite(data.weights[i]))
      throw InputError(fmt::format("row {}, weight is {}; it must be positive: drop the row", i + 1,
                                   data.weights[i]));
}

TrainingSet selected_rows(const TrainingSet& data, std::span<const Eigen::Index> rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  TrainingSet result{.x = Matrix(n, data.x.cols()), .y = Vector(n), .inputs = data.inputs};
  result.weights.resize(data.weights.size() > 0 ? n : 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index from = rows[static_cast<std::size_t>(i)];
    result.x.row(i) = data.x.row(from);
    result.y[i] = data.y[from];
    if (result.weights.size() > 0) result.weights[i] = data.weights[from];
  }
  result.groups = selected(data.groups, rows);
  result.replicates = selected(data.replicates, rows);
  return result;
}

}  // namespace repose::surrogate
