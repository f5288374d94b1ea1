#include "repose/surrogate/transfer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "repose/base/error.hpp"
#include "task.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;

/// Of rows that have none: 1 each.
Vector weights_of(const TrainingSet& data) {
  return data.weights.size() > 0 ? data.weights : Vector(Vector::Ones(data.rows()));
}

}  // namespace

const char* to_string(TransferMethod method) {
  switch (method) {
    case retrained:
      return "retrained";
    case target_only:
      return "target-only";
    case shift_and_scale:
      return "shift-and-scale";
    case source_basis:
      return "source-basis";
    case coregionalised:
      return "coregionalised";
    case weighted:
      return "weighted";
  }
  return "?";
}

TransferMethod transfer_method_named(std::string_view name) {
  std::vector<std::string> names;
  for (const TransferMethod method : kTransferMethods) {
    if (name == to_string(method)) return method;
    names.emplace_back(to_string(method));
  }
  throw InputError(
      fmt::format("there is no way of transfer '{}'; choose {}", name, fmt::join(names, ", ")));
}

void check_possible(TransferMethod method, const std::string& preset) {
  if (method != source_basis && method != coregionalised) return;
  if (!model_preset(preset).gaussian_process)
    throw InputError(
        fmt::format("transfer by {} needs a Gaussian process of the response as source; {} is "
                    "none: choose gpr, or another way of transfer",
                    to_string(method), preset));
}

Transfer transfer(const PretrainedModel& source, const TrainingSet& source_rows,
                  const TrainingSet& target, const TransferOptions& options) {
  if (target.rows() == 0) return {.model = source.model, .parts = {}};
  return TransferTask(source, source_rows, target, std::span(&options.method, 1), options.seed)
      .by(options.method);
}

TrainingSet joined(const TrainingSet& a, const TrainingSet& b) {
  const Eigen::Index n = a.rows(), m = b.rows();
  TrainingSet both{.x = Matrix(n + m, a.x.cols()), .y = Vector(n + m), .inputs = a.inputs};
  both.x << a.x, b.x;
  both.y << a.y, b.y;
  if (a.weights.size() > 0 || b.weights.size() > 0) {
    both.weights.resize(n + m);
    both.weights << weights_of(a), weights_of(b);
  }
  if (!a.groups.empty() && !b.groups.empty()) {
    both.groups = a.groups;
    both.groups.insert(both.groups.end(), b.groups.begin(), b.groups.end());
  }
  both.replicates = points_of(a);
  const Eigen::Index known = number_of_points(a);
  for (const Eigen::Index p : points_of(b)) both.replicates.push_back(known + p);
  return both;
}

}  // namespace repose::surrogate
