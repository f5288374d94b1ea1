// Pair laws by the indices of two materials.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "repose/dem/contact_law.hpp"
#include "repose/scene/case.hpp"

namespace repose::dem {

class LawTable {
 public:
  /// Laws of all pairs of the case while `stage` lasts (before the first of a simulation: the
  /// first); a pair that the case does not have stays unknown.
  LawTable(const scene::Case& scene, const scene::Stage* stage);

  /// The variant of the law, one for all pairs.
  const scene::ContactModel& model() const { return model_; }
  std::int32_t materials() const { return count_; }
  /// materials() by materials().
  const PairLaw* data() const { return laws_.data(); }
  const PairLaw& at(std::int32_t first, std::int32_t second) const {
    return laws_[static_cast<std::size_t>(first * count_ + second)];
  }
  /// Throws InputError if the case has no coefficients for this pair.
  void require(const scene::Case& scene, std::int32_t first, std::int32_t second) const;

 private:
  scene::ContactModel model_;
  std::int32_t count_;
  std::vector<PairLaw> laws_;
};

}  // namespace repose::dem
