// From a photograph to a view: contrast, threshold, patches, edge, components
// [Hadi2026, section 5.2.3].
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "patches.hpp"
#include "repose/base/error.hpp"
#include "repose/dem_adapter/view.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::size_t kBins = 256;
constexpr double kLeastContrast = 5.0;  // between the classes; about 2 is just noticed
constexpr double kSpeck = 0.05;         // of the area of the largest patch

/// The colour of the sky: median of each channel over the top tenth.
Rgb top_color(const Picture& picture) {
  const int rows = std::max(picture.height / 10, 1);
  const std::size_t count = picture.index(0, rows);
  Rgb color{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::array<std::size_t, 256> histogram{};
    for (std::size_t i = 0; i < count; ++i) ++histogram[picture.pixels[i][channel]];
    std::size_t below = 0;
    int value = 0;
    while ((below += histogram[static_cast<std::size_t>(value)]) <= count / 2) ++value;
    color[channel] = static_cast<std::uint8_t>(value);
  }
  return color;
}

struct Contrast {
  std::vector<float> value;
  std::vector<std::int16_t> nearest;  ///< component
};

/// Colour difference from the background, less that from the nearest component.
Contrast contrast_of(const Picture& picture, const Segmentation& segmentation) {
  const auto* empty_rig = std::get_if<Picture>(&segmentation.background);
  if (empty_rig != nullptr &&
      (empty_rig->width != picture.width || empty_rig->height != picture.height))
    throw InputError(fmt::format(
        "the background has {} x {} pixels, the picture {} x {}; take both from the same place",
        empty_rig->width, empty_rig->height, picture.width, picture.height));
  const auto* given = std::get_if<Rgb>(&segmentation.background);
  const Lab plain = lab_of(given != nullptr ? *given : top_color(picture));
  std::vector<Lab> colors;
  for (const auto& component : segmentation.components) colors.push_back(lab_of(component.color));
  Contrast contrast;
  contrast.value.resize(picture.pixels.size());
  contrast.nearest.assign(picture.pixels.size(), 0);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const Lab lab = lab_of(picture.pixels[i]);
    double value =
        color_difference(lab, empty_rig != nullptr ? lab_of(empty_rig->pixels[i]) : plain);
    double least = colors.empty() ? 0.0 : std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < colors.size(); ++k)
      if (const double difference = color_difference(lab, colors[k]); difference < least) {
        least = difference;
        contrast.nearest[i] = static_cast<std::int16_t>(k);
      }
    contrast.value[i] = static_cast<float>(value - least);
  }
  return contrast;
}

/// Median of the 3 x 3 pixels around each; those at the rim stay.
std::vector<float> median_filtered(const std::vector<float>& values, int width, int height) {
  std::vector<float> filtered = values;
  const auto w = static_cast<std::size_t>(width);
  for (std::size_t row = 1; row + 1 < static_cast<std::size_t>(height); ++row)
    for (std::size_t column = 1; column + 1 < w; ++column) {
      std::array<float, 9> near{};
      const std::size_t corner = (row - 1) * w + column - 1;
      for (std::size_t k = 0; k < 9; ++k) near[k] = values[corner + k / 3 * w + k % 3];
      std::nth_element(near.begin(), near.begin() + 4, near.end());
      filtered[row * w + column] = near[4];
    }
  return filtered;
}

/// Throws InputError unless the classes on both sides of the threshold differ as colours do.
void check_contrast(const std::vector<float>& values, double threshold) {
  double below = 0.0, above = 0.0, n_below = 0.0, n_above = 0.0;
  for (const float value : values) {
    (value > threshold ? above : below) += static_cast<double>(value);
    (value > threshold ? n_above : n_below) += 1.0;
  }
  if (n_above == 0.0)
    throw InputError(fmt::format(
        "nothing in the picture exceeds the threshold of contrast {:.4g}; give a lower one, the "
        "background's colour or the components' colours",
        threshold));
  if (n_below == 0.0 || above / n_above - below / n_below < kLeastContrast)
    throw InputError(fmt::format(
        "no heap stands out: the contrast on both sides of the threshold {:.4g} differs by {:.3g}, "
        "less than {} units of colour difference; crop the picture, give the background's colour "
        "or "
        "the components' colours, or light the rig evenly",
        threshold, n_below == 0.0 ? 0.0 : above / n_above - below / n_below, kLeastContrast));
}

/// Where the contrast crosses the threshold in each column, from the top.
Profile edge_of(const View& view, const std::vector<float>& contrast, double threshold) {
  const Picture& picture = view.picture;
  Profile profile{.first_x_m = view.left_m + 0.5 * view.pixel_m,
                  .column_m = view.pixel_m,
                  .top_m = std::vector<double>(static_cast<std::size_t>(picture.width),
                                               std::numeric_limits<double>::quiet_NaN())};
  const double top_m = view.bottom_m + picture.height * view.pixel_m;
  for (int column = 0; column < picture.width; ++column) {
    int row = 0;
    while (row < picture.height && view.label[picture.index(column, row)] == kBackground) ++row;
    if (row == 0 || row == picture.height) continue;  // cut off above, or empty
    const double outside = static_cast<double>(contrast[picture.index(column, row - 1)]);
    const double inside = static_cast<double>(contrast[picture.index(column, row)]);
    // Between the pixels' centres, at row - 1/2 and row + 1/2; a speck right above the edge that
    // was left out is no crossing.
    const double part = outside <= threshold ? (threshold - outside) / (inside - outside) : 0.5;
    profile.top_m[static_cast<std::size_t>(column)] = top_m - (row - 0.5 + part) * view.pixel_m;
  }
  return profile;
}

}  // namespace

double otsu_threshold(std::span<const float> values) {
  double largest = 0.0;
  for (const float value : values) largest = std::max(largest, static_cast<double>(value));
  if (!(largest > 0.0)) return 0.0;
  std::array<double, kBins> count{};
  for (const float value : values) {
    const double bin = std::max(static_cast<double>(value), 0.0) / largest * kBins;
    count[std::min(static_cast<std::size_t>(bin), kBins - 1)] += 1.0;
  }
  double total = 0.0, sum = 0.0;
  for (std::size_t b = 0; b < kBins; ++b) {
    total += count[b];
    sum += count[b] * static_cast<double>(b);
  }
  // omega0 omega1 (mu0 - mu1)^2, [Otsu1979, Eq. 14]
  double best = -1.0, n0 = 0.0, sum0 = 0.0;
  std::size_t first = 0, last = 0;
  for (std::size_t b = 0; b + 1 < kBins; ++b) {
    n0 += count[b];
    sum0 += count[b] * static_cast<double>(b);
    if (n0 == 0.0 || n0 == total) continue;
    const double difference = sum0 / n0 - (sum - sum0) / (total - n0);
    const double between = n0 * (total - n0) * difference * difference;
    if (between > best) {
      best = between;
      first = last = b;
    } else if (between == best) {
      last = b;
    }
  }
  return (0.5 * static_cast<double>(first + last) + 1.0) / kBins * largest;
}

View view_of_photograph(const Picture& picture, const Segmentation& segmentation,
                        std::optional<double> scale_m, int column, int row) {
  const double pixel_m = scale_m.value_or(1.0);
  Contrast contrast = contrast_of(picture, segmentation);
  contrast.value = median_filtered(contrast.value, picture.width, picture.height);
  const bool by_component = !segmentation.components.empty();
  const double threshold =
      segmentation.threshold.value_or(by_component ? 0.0 : otsu_threshold(contrast.value));
  check_contrast(contrast.value, threshold);

  View view;
  view.picture = picture;
  view.unit = scale_m ? "m" : "px";
  view.pixel_m = pixel_m;
  view.left_m = column * pixel_m;
  view.bottom_m = -(row + picture.height) * pixel_m;
  view.label.assign(picture.pixels.size(), kBackground);
  for (std::size_t i = 0; i < view.label.size(); ++i)
    if (static_cast<double>(contrast.value[i]) > threshold) view.label[i] = contrast.nearest[i];
  remove_specks(view.label, picture.width, picture.height, kSpeck);
  for (const auto& component : segmentation.components) view.components.push_back(component.name);
  if (!by_component) view.components = {"heap"};
  view.profile = edge_of(view, contrast.value, threshold);
  int cut = 0;
  for (int c = 0; c < picture.width; ++c)
    cut += view.label[picture.index(c, 0)] != kBackground ? 1 : 0;
  if (cut > 0)
    view.warnings.push_back(fmt::format(
        "{} of {} columns reach the picture's upper edge and have none of their own; crop less",
        cut, picture.width));
  return view;
}

}  // namespace repose::dem_adapter
