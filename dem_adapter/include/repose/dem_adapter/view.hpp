// A heap or a slope as it is seen from the front: from a photograph by segmentation, from particles
// by projection. What is measured on a view does not know which.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "repose/dem_adapter/picture.hpp"
#include "repose/dem_adapter/silhouette.hpp"
#include "repose/scene/run_records.hpp"

namespace repose::dem_adapter {

/// x to the right and z up; rows of pixels count from the top.
struct View {
  Picture picture;  ///< as seen, for the audit picture
  /// "m", or "px" for a photograph without scale, whose lengths are then all in pixels.
  std::string unit = "m";
  double pixel_m = 1.0;
  double largest_grain_m = 0.0;  ///< diameter; 0 if unknown
  double left_m = 0.0;           ///< x of the picture's left edge
  double bottom_m = 0.0;         ///< z of its lower edge
  Profile profile;               ///< the upper edge of all components, one column a pixel
  std::vector<std::string> components;
  /// Of each pixel: the index of its component, or kBackground.
  std::vector<std::int16_t> label;
  std::vector<std::string> warnings;
};
inline constexpr std::int16_t kBackground = -1;

/// A component of the mixture in a photograph.
struct ColoredComponent {
  std::string name;
  Rgb color{};
};

/// How a photograph is told apart. For each pixel a contrast is computed, smoothed by the median of
/// 3 x 3 pixels and compared with a threshold; patches of less than a twentieth of the largest are
/// specks and left out.
struct Segmentation {
  /// A colour, a photograph of the empty rig from the same place (of the same size, cropped alike),
  /// or, if empty, the median colour of the top tenth of the picture.
  std::variant<std::monostate, Rgb, Picture> background{};
  /// Without components, contrast is the colour difference from the background. With them each
  /// pixel is what it resembles most in CIELAB, and contrast is the difference from the background
  /// less that from the nearest component.
  std::vector<ColoredComponent> components{};
  /// Of the contrast. Default: by the method of Otsu [Otsu1979] without components, 0 with them.
  std::optional<double> threshold{};
};

/// `pixel_m` is the width of a pixel, m, if it is known; `column`, `row` say which pixel of a
/// larger picture is the upper left one: x = column * pixel_m at the left edge, z = -row * pixel_m
/// at the upper one. The edge is found within pixels, where the contrast crosses the threshold.
/// Throws InputError if nothing stands out: less than five units of colour difference between the
/// two sides of the threshold, or no component.
View view_of_photograph(const Picture& picture, const Segmentation& segmentation,
                        std::optional<double> pixel_m = {}, int column = 0, int row = 0);

/// The threshold that splits values in [0, largest] into two classes with the greatest variance
/// between them [Otsu1979], from a histogram of 256 bins; the middle of a plateau.
double otsu_threshold(std::span<const float> values);

/// Which way the camera looks: along y with x to the right, or along x with y to the right.
enum class ViewDirection { along_y, along_x };

struct ParticleViewOptions {
  ViewDirection direction = ViewDirection::along_y;
  double pixel_m =
      0.0;  ///< 0: a tenth of the smallest diameter, larger if 4 million pixels are few
  /// Left and right, lower and upper end of what is seen, m; default: all of the particles.
  std::optional<double> left_m{}, right_m{}, bottom_m{}, top_m{};
  double fastest_m_s = 0.2;               ///< faster particles are in flight, no part of the heap
  std::optional<scene::Region> region{};  ///< only particles with centres in it
};

/// Components are the materials of the spheres seen; the nearest sphere hides others, the edge is
/// that of silhouette() at pixel centres. Throws InputError if no sphere is seen.
View view_of_particles(const scene::Snapshot& snapshot, const ParticleViewOptions& options = {});

}  // namespace repose::dem_adapter
