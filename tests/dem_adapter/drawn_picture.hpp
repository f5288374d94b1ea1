// Pictures of heaps whose angles are known, drawn with smooth edges, and files that hold them.
#pragma once

#include <filesystem>
#include <functional>

#include "repose/dem_adapter/picture.hpp"

namespace repose::test {

/// Each pixel is a mixture of two colours by the share of its area that is inside, from 8 x 8
/// points; x to the right and y downwards, in pixels.
dem_adapter::Picture drawn(int width, int height, dem_adapter::Rgb outside,
                           const std::function<dem_adapter::Rgb(double, double)>& inside_color,
                           const std::function<bool(double, double)>& is_inside);

/// A cone with its tip at (axis, tip) standing on the row `floor`.
struct Cone {
  double axis = 0.0, tip = 0.0, floor = 0.0, left_deg = 30.0, right_deg = 30.0;
  bool has(double x, double y) const;
};

/// Adds normal noise to each channel, and `specks` single pixels of any colour.
void add_noise(dem_adapter::Picture& picture, double deviation, int specks, std::uint64_t seed);

/// A JPEG file of the quality given, with an EXIF orientation unless it is 0.
std::string jpeg_of(const dem_adapter::Picture& picture, int quality, int orientation = 0);

/// A grey JPEG file in the colours of a printer.
std::string cmyk_jpeg(int width, int height);

void write_bytes(const std::filesystem::path& path, const std::string& bytes);

}  // namespace repose::test
