// The checks of a case by subject, and what they share.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "repose/scene/case.hpp"

namespace repose::scene {

inline constexpr const char* kAxes[3] = {"x", "y", "z"};

/// Throws InputError "quantity = value: what".
[[noreturn]] void refuse(const std::string& quantity, double value, const std::string& what);
void require_positive(const std::string& quantity, double value);
void require_non_negative(const std::string& quantity, double value);
void require_finite(const std::string& quantity, const Vec3& value);
/// Names that differ, are not empty and have no "/", which columns of the output cannot have.
void require_unique(const char* kind, const std::vector<std::string>& names);
template <class Items>
void require_unique_names(const char* kind, const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  require_unique(kind, names);
}
/// Throws InputError if `lower` to `upper` is not a box within the domain.
void require_box(const Case& scene, const std::string& what, const Vec3& lower, const Vec3& upper);

bool is_periodic(const Case& scene, int axis);
/// Index of a stage; throws InputError beginning with `what` that lists the known ones.
std::size_t stage_index(const Case& scene, const std::string& what, const std::string& name);
/// The time from the beginning of `stage` (of the run, if empty) to the end of the last stage if
/// all last as long as they may.
double longest_time_after_s(const Case& scene, const std::string& what, const std::string& stage);

/// Throws InputError as clump_shape() does; an empty name is a sphere.
void require_clump(const Case& scene, const std::string& what, const std::string& name);
/// The diameter of the sphere about the centre of mass that holds a particle, over its
/// volume-equivalent diameter; 1 for a sphere.
double bounding_ratio(const Case& scene, const std::string& clump);
/// Of the sphere around the largest particle of a mixture.
double largest_bounding_diameter_m(const Case& scene, const std::vector<Grains>& mixture);
/// A period holds two of the largest particles.
void check_diameter_in_periods(const Case& scene, const std::string& what, double diameter_m);
void check_mixture(const Case& scene, const std::string& what, const std::vector<Grains>& mixture);

void check_materials(const Case& scene);
void check_clumps(const Case& scene);
void check_walls(const Case& scene);
void check_motions(const Case& scene);
void check_regions(const Case& scene);
void check_insertion(const Case& scene);
void check_pairs_present(const Case& scene);
void check_stages(const Case& scene);

}  // namespace repose::scene
