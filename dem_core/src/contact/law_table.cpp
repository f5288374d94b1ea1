#include "contact/law_table.hpp"

#include "repose/base/error.hpp"

namespace repose::dem {

LawTable::LawTable(const scene::Case& scene, const scene::Stage* stage)
    : model_(scene.contact),
      count_(static_cast<std::int32_t>(scene.materials.size())),
      laws_(scene.materials.size() * scene.materials.size()) {
  for (std::int32_t a = 0; a < count_; ++a)
    for (std::int32_t b = 0; b < count_; ++b) {
      const int index = scene::pair_index(scene, a, b);
      if (index < 0) continue;
      scene::PairCoefficients pair = scene.pairs[static_cast<std::size_t>(index)];
      if (stage != nullptr && stage->coefficients) {
        pair.restitution = stage->coefficients->restitution;
        pair.mu_s = stage->coefficients->mu_s;
        pair.mu_r = stage->coefficients->mu_r;
      }
      laws_[static_cast<std::size_t>(a * count_ + b)] =
          make_pair_law(scene.materials[static_cast<std::size_t>(a)],
                        scene.materials[static_cast<std::size_t>(b)], pair, model_);
    }
}

void LawTable::require(const scene::Case& scene, std::int32_t first, std::int32_t second) const {
  if (at(first, second).e_eff > 0.0) return;
  throw InputError("pair [\"" + scene.materials[static_cast<std::size_t>(first)].name + "\", \"" +
                   scene.materials[static_cast<std::size_t>(second)].name +
                   "\"] is missing; add a [[pair]] with restitution, mu_s and mu_r");
}

}  // namespace repose::dem
