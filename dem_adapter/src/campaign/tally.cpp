#include "tally.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::size_t kEnoughToJudge = 10;

}  // namespace

std::string counts_text(const std::map<Outcome, std::size_t>& counts) {
  std::vector<std::pair<std::size_t, Outcome>> order;
  for (const auto& [outcome, count] : counts)
    if (outcome != Outcome::finished) order.emplace_back(count, outcome);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [count, outcome] : order)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, to_string(outcome));
  return text;
}

Tally::Tally(std::size_t wanted, double stop_above, ProgressCallback progress)
    : wanted_(wanted),
      stop_above_(stop_above),
      progress_(std::move(progress)),
      began_(std::chrono::steady_clock::now()) {}

void Tally::found(const RunOutcome& outcome) {
  ++done_;
  ++counts_[outcome.measurement.outcome];
  if (!outcome.failed()) return;
  ++failed_;
  example_ = outcome.measurement.failure;
}

void Tally::begin() {
  began_ = std::chrono::steady_clock::now();
  report();
  check();
}

void Tally::finished(const RunOutcome& outcome) {
  const std::lock_guard lock(mutex_);
  found(outcome);
  ++new_;
  report();
  check();
}

std::string Tally::note() const {
  auto text = fmt::format("{} of {} runs", done_, wanted_);
  if (failed_ > 0) text += fmt::format(", {} failed", failed_);
  const double minutes =
      std::chrono::duration<double, std::ratio<60>>(std::chrono::steady_clock::now() - began_)
          .count();
  if (new_ > 0 && minutes > 0.0)
    text += fmt::format(", {:.3g}/min", static_cast<double>(new_) / minutes);
  return text;
}

void Tally::report() const {
  if (progress_) progress_(static_cast<double>(done_), static_cast<double>(wanted_), note());
}

void Tally::check() const {
  if (done_ < kEnoughToJudge ||
      static_cast<double>(failed_) <= stop_above_ * static_cast<double>(done_))
    return;
  throw SimulationError(fmt::format(
      "{} of {} runs failed ({}), more than the share stop_above = {}; e.g. \"{}\". Change the "
      "ranges, or raise stop_above and call again: what has finished is kept",
      failed_, done_, counts_text(counts_), shortest(stop_above_), example_));
}

}  // namespace repose::dem_adapter
