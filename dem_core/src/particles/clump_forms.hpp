// The clump forms of a case, each computed once.
#pragma once

#include <algorithm>
#include <deque>
#include <string>

#include "repose/scene/case.hpp"
#include "repose/scene/clump_form.hpp"

namespace repose::dem {

class ClumpForms {
 public:
  explicit ClumpForms(const scene::Case& scene) : scene_(scene) {}

  /// Null for the empty name, a sphere. Throws InputError for an unknown one.
  const scene::ClumpForm* find(const std::string& name) {
    if (name.empty()) return nullptr;
    for (const Entry& entry : entries_)
      if (entry.name == name) return &entry.form;
    entries_.push_back({name, scene::clump_form(scene::clump_shape(scene_, name))});
    return &entries_.back().form;
  }

  /// Radius of the largest constituent sphere over that of the particle.
  static double largest_sphere(const scene::ClumpForm* form) {
    if (form == nullptr) return 1.0;
    double largest = 0.0;
    for (const auto& sphere : form->spheres) largest = std::max(largest, sphere.radius);
    return largest;
  }

 private:
  struct Entry {
    std::string name;
    scene::ClumpForm form;
  };
  const scene::Case& scene_;
  std::deque<Entry> entries_;  // addresses stay
};

}  // namespace repose::dem
