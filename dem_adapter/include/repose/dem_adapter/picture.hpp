// Pictures in memory, PNG and JPEG files, and colours as people see them (CIELAB).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace repose::dem_adapter {

/// Red, green and blue of sRGB [IEC61966-2-1], 0 to 255.
using Rgb = std::array<std::uint8_t, 3>;

/// Rows from the top, pixels from the left; 8 bits a channel.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;  ///< width * height
  Picture() = default;
  Picture(int columns, int rows, Rgb fill = {255, 255, 255});
  const Rgb& at(int column, int row) const { return pixels[index(column, row)]; }
  Rgb& at(int column, int row) { return pixels[index(column, row)]; }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }
};

/// Part of a picture: the pixel in its upper left corner and its size.
struct PixelBox {
  int column = 0, row = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

/// More pixels are refused: 100 million need about a gigabyte.
inline constexpr std::size_t kMostPixels = 100'000'000;

/// A PNG or JPEG file, told by its content. Grey, palette and 16-bit PNG become RGB (as sRGB,
/// unless the file says that it is encoded otherwise), transparent pixels white; JPEG is turned as
/// its EXIF orientation says. Throws StorageError if the file cannot be read, InputError if it is
/// neither, is damaged, in CMYK, has fewer than 16 x 16 pixels or too many.
Picture read_picture(const std::filesystem::path& path);

/// Throws InputError unless the box lies within the picture.
Picture cropped(const Picture& picture, const PixelBox& box);

/// A place in a picture, from its upper left corner, in pixels.
struct PixelPoint {
  double column = 0.0, row = 0.0;
};

/// How far the line through two points that should be level falls to the right. Throws InputError
/// if they are less than 16 columns apart, or by more than 20 degrees off.
double tilt_deg(const PixelPoint& first, const PixelPoint& second);

/// Turned back about its middle by this angle, of the same size; linear between pixels, and
/// beyond the rim the colour of the nearest pixel.
Picture leveled(const Picture& picture, double tilt_deg);

/// The bytes of a PNG file.
std::string png_of(const Picture& picture);

/// CIELAB, D65, 2 degrees [CIE15]: L* is 0 (black) to 100 (white); a*, b* about -128 to 128.
struct Lab {
  double l = 0.0, a = 0.0, b = 0.0;
};
Lab lab_of(Rgb color);

/// Colour difference of 1976, the distance in CIELAB [CIE15]: about 2 is just noticed.
double color_difference(const Lab& first, const Lab& second);

/// "#rrggbb" or "rrggbb". Throws InputError that says so.
Rgb parse_color(std::string_view text);

}  // namespace repose::dem_adapter
