#include "repose/surrogate/selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "repose/base/error.hpp"
#include "repose/base/thread_pool.hpp"

namespace repose::surrogate {
namespace {

struct Trial {
  Candidate candidate;
  std::optional<GaussianProcess> model;
};

std::vector<Trial> trials_of(const SelectionOptions& selection) {
  std::vector<Trial> trials;
  for (const Basis basis : selection.bases)
    for (const Kernel kernel : selection.kernels)
      trials.push_back({{.kernel = kernel, .basis = basis}, std::nullopt});
  if (trials.empty()) throw InputError("a selection among no kernels or no bases");
  return trials;
}

void score(Candidate& c, const GaussianProcess& model, const SelectionOptions& selection) {
  const LeftOut out =
      selection.groups.empty() ? model.leave_one_out() : model.leave_groups_out(selection.groups);
  c.log_density = out.log_density;
  c.q2 = out.q2;
  c.rmse = out.rmse;
  c.coverage95 = out.coverage95;
  c.negative_log_likelihood = model.negative_log_likelihood();
  c.seconds = model.report().seconds;
  const auto undefined = out.predicted.array().isNaN().count();
  if (undefined > 0)
    c.failure = fmt::format("{} rows cannot be predicted without their group", undefined);
}

double rank_of(const Candidate& c) {
  if (c.failure.empty()) return c.log_density;
  return -std::numeric_limits<double>::infinity();
}

}  // namespace

Selection select_model(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                       const GaussianProcessOptions& options, const SelectionOptions& selection) {
  if (!selection.groups.empty() && static_cast<Eigen::Index>(selection.groups.size()) != y.size())
    throw InputError(
        fmt::format("{} groups for {} rows; each row has one", selection.groups.size(), y.size()));
  std::vector<Trial> trials = trials_of(selection);
  parallel_for(trials.size(), selection.threads, [&](std::size_t i) {
    GaussianProcessOptions o = options;
    o.kernel = trials[i].candidate.kernel;
    o.basis = trials[i].candidate.basis;
    o.threads = 1;
    try {
      trials[i].model = GaussianProcess::fit(x, y, inputs, o);
      score(trials[i].candidate, *trials[i].model, selection);
    } catch (const Error& error) {
      trials[i].candidate.failure = error.what();
    }
  });
  std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
    if (a.model.has_value() != b.model.has_value()) return a.model.has_value();
    return rank_of(a.candidate) > rank_of(b.candidate);
  });
  if (!trials.front().model)
    throw InputError(fmt::format("none of {} models could be fitted; the first: {}", trials.size(),
                                 trials.front().candidate.failure));
  Selection result{.model = *trials.front().model};
  for (Trial& trial : trials) result.candidates.push_back(std::move(trial.candidate));
  return result;
}

}  // namespace repose::surrogate
