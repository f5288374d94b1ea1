// PNG by libpng's simplified interface, which never jumps out.
#include <fmt/format.h>
#include <png.h>

#include "formats.hpp"
#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

/// Frees what libpng holds, whatever happens.
struct PngImage {
  png_image image{};
  PngImage() { image.version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(&image); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
};

[[noreturn]] void damaged(const std::string& name, const char* why) {
  throw InputError(
      fmt::format("'{}' is a damaged PNG file ({}); take a copy or save it anew", name, why));
}

}  // namespace

Picture read_png(const std::string& bytes, const std::string& name) {
  PngImage png;
  if (png_image_begin_read_from_memory(&png.image, bytes.data(), bytes.size()) == 0)
    damaged(name, png.image.message);
  check_size(name, png.image.width, png.image.height);
  png.image.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // where the file does not say otherwise
  png.image.format = PNG_FORMAT_RGB;
  Picture picture(static_cast<int>(png.image.width), static_cast<int>(png.image.height));
  const png_color white{255, 255, 255};
  static_assert(sizeof(Rgb) == 3);
  if (png_image_finish_read(&png.image, &white, picture.pixels.data(), 0, nullptr) == 0 ||
      (png.image.warning_or_error & PNG_IMAGE_ERROR) != 0)
    damaged(name, png.image.message);
  return picture;
}

std::string png_of(const Picture& picture) {
  PngImage png;
  png.image.width = static_cast<png_uint_32>(picture.width);
  png.image.height = static_cast<png_uint_32>(picture.height);
  png.image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png.image);
  std::string bytes(size, '\0');
  const int written = png_image_write_to_memory(&png.image, bytes.data(), &size, 0,
                                                picture.pixels.data(), 0, nullptr);
  REPOSE_ASSERT(written != 0, png.image.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace repose::dem_adapter
