#include "patches.hpp"

#include <algorithm>
#include <cstddef>

namespace repose::dem_adapter {
namespace {

constexpr std::uint32_t kNone = 0;

/// Numbers of patches, joined as they turn out to be one [union-find, roots are smallest].
class Patches {
 public:
  std::uint32_t make() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }
  std::uint32_t root(std::uint32_t patch) {
    while (parent_[patch] != patch) patch = parent_[patch] = parent_[parent_[patch]];
    return patch;
  }
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return std::min(a, b);
  }
  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_{kNone};
};

}  // namespace

void remove_specks(std::vector<std::int16_t>& label, int width, int height, double fraction) {
  const auto w = static_cast<std::size_t>(width);
  Patches patches;
  std::vector<std::uint32_t> patch(label.size(), kNone);
  for (std::size_t i = 0; i < label.size() && i < w * static_cast<std::size_t>(height); ++i) {
    if (label[i] < 0) continue;
    const std::uint32_t left = i % w > 0 ? patch[i - 1] : kNone;
    const std::uint32_t above = i >= w ? patch[i - w] : kNone;
    if (left != kNone && above != kNone)
      patch[i] = patches.join(left, above);
    else
      patch[i] = left != kNone ? left : above != kNone ? above : patches.make();
  }
  std::vector<std::size_t> area(patches.size(), 0);
  for (std::uint32_t& p : patch)
    if (p != kNone) ++area[p = patches.root(p)];
  const double least = fraction * static_cast<double>(*std::max_element(area.begin(), area.end()));
  for (std::size_t i = 0; i < label.size(); ++i)
    if (patch[i] != kNone && static_cast<double>(area[patch[i]]) < least) label[i] = -1;
}

}  // namespace repose::dem_adapter
