#include "drawn_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include <jpeglib.h>

#include "repose/base/random.hpp"

namespace repose::test {

using dem_adapter::Picture;
using dem_adapter::Rgb;

Picture drawn(int width, int height, Rgb outside,
              const std::function<Rgb(double, double)>& inside_color,
              const std::function<bool(double, double)>& is_inside) {
  constexpr int kPoints = 8;
  Picture picture(width, height, outside);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const int corners = is_inside(column, row) + is_inside(column + 1.0, row) +
                          is_inside(column, row + 1.0) + is_inside(column + 1.0, row + 1.0);
      if (corners == 0) continue;  // the shapes have no detail smaller than a pixel
      int inside = corners == 4 ? kPoints * kPoints : 0;
      for (int k = 0; k < kPoints * kPoints && corners < 4; ++k)
        inside +=
            is_inside(column + (k % kPoints + 0.5) / kPoints, row + (k / kPoints + 0.5) / kPoints)
                ? 1
                : 0;
      const double share = static_cast<double>(inside) / (kPoints * kPoints);
      const Rgb color = inside_color(column + 0.5, row + 0.5);
      for (std::size_t c = 0; c < 3; ++c)
        picture.at(column, row)[c] =
            static_cast<std::uint8_t>(std::lround((1.0 - share) * outside[c] + share * color[c]));
    }
  return picture;
}

bool Cone::has(double x, double y) const {
  const double side = x < axis ? left_deg : right_deg;
  return y < floor && y - tip > std::abs(x - axis) * std::tan(side * std::numbers::pi / 180.0);
}

void add_noise(Picture& picture, double deviation, int specks, std::uint64_t seed) {
  RandomStream random(seed);
  for (Rgb& pixel : picture.pixels)
    for (auto& channel : pixel)
      channel = static_cast<std::uint8_t>(
          std::clamp(std::lround(channel + deviation * random.normal()), 0L, 255L));
  for (int i = 0; i < specks; ++i)
    for (auto& channel : picture.pixels[random.below(picture.pixels.size())])
      channel = static_cast<std::uint8_t>(random.below(256));
}

namespace {

/// A JPEG file of rows of samples.
struct JpegFile {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  JpegFile(int width, int height, int channels, J_COLOR_SPACE colors, int quality) {
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    jpeg_mem_dest(&info, &buffer, &size);
    info.image_width = static_cast<JDIMENSION>(width);
    info.image_height = static_cast<JDIMENSION>(height);
    info.input_components = channels;
    info.in_color_space = colors;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, quality, TRUE);
    jpeg_start_compress(&info, TRUE);
  }
  ~JpegFile() {
    jpeg_destroy_compress(&info);
    std::free(buffer);
  }
  void add_row(const std::uint8_t* samples) {
    auto* line = const_cast<JSAMPLE*>(samples);
    jpeg_write_scanlines(&info, &line, 1);
  }
  std::string bytes() {
    jpeg_finish_compress(&info);
    return {reinterpret_cast<const char*>(buffer), size};
  }
};

}  // namespace

std::string jpeg_of(const Picture& picture, int quality, int orientation) {
  JpegFile file(picture.width, picture.height, 3, JCS_RGB, quality);
  if (orientation > 0) {
    // Big-endian TIFF with one directory of one entry: orientation, a short.
    const std::string exif =
        std::string("Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 25) +
        static_cast<char>(orientation) + std::string(6, '\0');
    jpeg_write_marker(&file.info, JPEG_APP0 + 1, reinterpret_cast<const JOCTET*>(exif.data()),
                      static_cast<unsigned>(exif.size()));
  }
  for (int row = 0; row < picture.height; ++row) file.add_row(picture.at(0, row).data());
  return file.bytes();
}

std::string cmyk_jpeg(int width, int height) {
  JpegFile file(width, height, 4, JCS_CMYK, 90);
  const std::vector<std::uint8_t> samples(4 * static_cast<std::size_t>(width), 100);
  for (int row = 0; row < height; ++row) file.add_row(samples.data());
  return file.bytes();
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace repose::test
