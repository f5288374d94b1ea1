// The search for regular two-level fractions of minimum aberration.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "fractions.hpp"
#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

using Pattern = std::vector<int>;  // words of each length

/// Depth first over increasing sets of base products. Adding a generator only adds words, so a
/// set whose pattern is already no better than the best one cannot become better.
class Search {
 public:
  Search(int base_factors, int generators, std::vector<FactorProduct> candidates,
         std::int64_t budget)
      : base_factors_(base_factors),
        wanted_(static_cast<std::size_t>(generators)),
        candidates_(std::move(candidates)),
        budget_(budget),
        words_{0} {}

  void run() { descend(0, Pattern(static_cast<std::size_t>(base_factors_) + wanted_ + 1, 0)); }
  bool exhausted() const { return budget_ > 0; }
  const std::vector<FactorProduct>& best() const { return best_; }

 private:
  /// Base factors can be renamed: of the earliest length that occurs, one generator may be taken to
  /// be AB, ABC, ..., which comes first of its length.
  bool is_first_factors(FactorProduct product) const { return (product & (product + 1)) == 0; }

  void descend(std::size_t from, const Pattern& pattern) {
    if (chosen_.size() == wanted_) {
      best_ = chosen_;
      best_pattern_ = pattern;
      return;
    }
    for (std::size_t i = from; i < candidates_.size() && budget_ > 0; ++i) {
      if (candidates_.size() - i < wanted_ - chosen_.size()) return;
      if (chosen_.empty() && !is_first_factors(candidates_[i])) continue;
      budget_ -= 1 + static_cast<std::int64_t>(words_.size()) / 16;
      const Pattern next = with_word(pattern, i);
      if (!best_.empty() && next >= best_pattern_) continue;
      const std::size_t before = words_.size();
      for (std::size_t w = 0; w < before; ++w) words_.push_back(words_[w] ^ word(i));
      chosen_.push_back(candidates_[i]);
      descend(i + 1, next);
      chosen_.pop_back();
      words_.resize(before);
    }
  }
  FactorProduct word(std::size_t candidate) const {
    return candidates_[candidate] |
           FactorProduct{1} << (static_cast<std::size_t>(base_factors_) + chosen_.size());
  }
  Pattern with_word(Pattern pattern, std::size_t candidate) const {
    const FactorProduct added = word(candidate);
    for (const FactorProduct w : words_)
      ++pattern[static_cast<std::size_t>(std::popcount(w ^ added))];
    return pattern;
  }

  int base_factors_;
  std::size_t wanted_;
  std::vector<FactorProduct> candidates_;
  std::int64_t budget_;
  std::vector<FactorProduct> words_;
  std::vector<FactorProduct> chosen_;
  std::vector<FactorProduct> best_;
  Pattern best_pattern_;
};

/// Products of an odd number of base factors first, the longest first: alone they give resolution
/// IV, and good fractions are met early.
std::vector<FactorProduct> candidate_products(int base_factors, bool only_odd) {
  std::vector<FactorProduct> products;
  for (FactorProduct p = 1; p < FactorProduct{1} << base_factors; ++p)
    if (std::popcount(p) >= 2 && (!only_odd || std::popcount(p) % 2 == 1)) products.push_back(p);
  std::stable_sort(products.begin(), products.end(), [](FactorProduct a, FactorProduct b) {
    const int la = std::popcount(a), lb = std::popcount(b);
    return la % 2 != lb % 2 ? la % 2 == 1 : la > lb;
  });
  return products;
}

}  // namespace

FractionalFactorial minimum_aberration(int factors, int runs, std::int64_t search_budget) {
  const bool power = runs >= 4 && runs <= 65536 && std::has_single_bit(static_cast<unsigned>(runs));
  if (!power)
    throw InputError(fmt::format(
        "two-level fraction: {} runs; a power of two from 4 to 65536 is possible", runs));
  const int m = std::countr_zero(static_cast<unsigned>(runs));
  if (factors < m || factors >= runs || factors > 25)
    throw InputError(
        fmt::format("two-level fraction: {} factors in {} runs; from {} to {} factors "
                    "are possible there",
                    factors, runs, m, std::min(runs - 1, 25)));
  if (search_budget < 1)
    throw InputError(
        fmt::format("two-level fraction: a search of {} steps; give it 1 or more", search_budget));
  if (factors == m) {
    auto full = fraction_of(m, {});
    full.is_minimum_aberration = true;
    return full;
  }
  // Above 5/16 of the runs every fraction of resolution IV consists of odd products
  // [DavydovTombak1990]; up to half of the runs there is one.
  const bool only_odd = 16 * factors > 5 * runs && 2 * factors <= runs;
  Search search(m, factors - m, candidate_products(m, only_odd), search_budget);
  search.run();
  auto products = search.best();
  std::sort(products.begin(), products.end());
  auto design = fraction_of(m, std::move(products));
  design.is_minimum_aberration = search.exhausted();
  return design;
}

}  // namespace repose::doe
