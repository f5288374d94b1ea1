// JPEG by libjpeg, whose errors come as jumps that stay inside decode().
#include <fmt/format.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <jpeglib.h>

#include "formats.hpp"
#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

constexpr int kExif = JPEG_APP0 + 1;

struct Failure {
  jpeg_error_mgr manager{};
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX] = "";
};

Failure& failure_of(j_common_ptr info) {
  return *static_cast<Failure*>(info->client_data);
}

[[noreturn]] void leave(j_common_ptr info) {
  Failure& failure = failure_of(info);
  (*info->err->format_message)(info, failure.message);
  std::longjmp(failure.jump, 1);
}

/// Warnings mean lost data; the last one is kept, none is printed.
void keep_warning(j_common_ptr info, int level) {
  if (level >= 0) return;
  ++info->err->num_warnings;
  (*info->err->format_message)(info, failure_of(info).message);
}

/// The value of tag 0x0112 in the first directory of an EXIF block: 1 (upright) to 8; 1 if there is
/// none. [EXIF, section 4.6]
int orientation_of(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHeader = 6;  // "Exif", two zeros; then a TIFF header
  if (size < kHeader + 8 || std::memcmp(data, "Exif\0\0", kHeader) != 0) return 1;
  const std::uint8_t* tiff = data + kHeader;
  const std::size_t length = size - kHeader;
  const bool little = tiff[0] == 'I';
  const auto number = [&](std::size_t at, int bytes) -> std::size_t {
    if (at + static_cast<std::size_t>(bytes) > length) return 0;
    std::size_t value = 0;
    for (int i = 0; i < bytes; ++i)
      value = value << 8 | tiff[at + static_cast<std::size_t>(little ? bytes - 1 - i : i)];
    return value;
  };
  const std::size_t directory = number(4, 4), entries = number(directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (entry + 12 > length) break;
    if (number(entry, 2) != 0x0112) continue;
    const auto value = static_cast<int>(number(entry + 8, 2));
    return value >= 1 && value <= 8 ? value : 1;
  }
  return 1;
}

/// What decode() fills; no object with a destructor lives in the frame that is jumped out of.
struct Decoded {
  Picture picture;
  J_COLOR_SPACE colors = JCS_UNKNOWN;
  int orientation = 1;
  std::size_t width = 0, height = 0;
};

enum class Decoding { header, pixels };

/// Reads header or pixels; false with the reason in `failure` if the file is damaged.
bool decode(const std::string& bytes, Decoding what, Decoded& to, Failure& failure) {
  jpeg_decompress_struct info{};
  info.err = jpeg_std_error(&failure.manager);
  failure.manager.error_exit = &leave;
  failure.manager.emit_message = &keep_warning;
  info.client_data = &failure;
  if (setjmp(failure.jump) != 0) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_save_markers(&info, kExif, 0xFFFF);
  jpeg_read_header(&info, TRUE);
  if (what == Decoding::header) {
    to.width = info.image_width;
    to.height = info.image_height;
    to.colors = info.jpeg_color_space;
    for (auto marker = info.marker_list; marker != nullptr; marker = marker->next)
      if (marker->marker == kExif && to.orientation == 1)
        to.orientation = orientation_of(marker->data, marker->data_length);
  } else {
    info.out_color_space = JCS_RGB;
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
      auto* row =
          reinterpret_cast<JSAMPLE*>(&to.picture.at(0, static_cast<int>(info.output_scanline)));
      jpeg_read_scanlines(&info, &row, 1);
    }
    jpeg_finish_decompress(&info);
  }
  jpeg_destroy_decompress(&info);
  return failure.manager.num_warnings == 0;
}

/// The pixel at (column, row) of an upright picture, for EXIF orientations 1 to 8.
Picture turned(const Picture& from, int orientation) {
  if (orientation == 1) return from;
  const bool swaps = orientation >= 5;
  Picture to(swaps ? from.height : from.width, swaps ? from.width : from.height);
  const bool mirrors_columns =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool mirrors_rows =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  for (int row = 0; row < to.height; ++row)
    for (int column = 0; column < to.width; ++column) {
      const int x = swaps ? row : column, y = swaps ? column : row;
      to.at(column, row) =
          from.at(mirrors_columns ? from.width - 1 - x : x, mirrors_rows ? from.height - 1 - y : y);
    }
  return to;
}

[[noreturn]] void damaged(const std::string& name, const Failure& failure) {
  throw InputError(fmt::format("'{}' is a damaged JPEG file ({}); take a copy or save it anew",
                               name, failure.message));
}

}  // namespace

Picture read_jpeg(const std::string& bytes, const std::string& name) {
  Failure failure;
  Decoded decoded;
  if (!decode(bytes, Decoding::header, decoded, failure)) damaged(name, failure);
  if (decoded.colors == JCS_CMYK || decoded.colors == JCS_YCCK)
    throw InputError(fmt::format(
        "'{}' is a JPEG file in the colours of a printer (CMYK); save it as RGB", name));
  check_size(name, decoded.width, decoded.height);
  decoded.picture = Picture(static_cast<int>(decoded.width), static_cast<int>(decoded.height));
  if (!decode(bytes, Decoding::pixels, decoded, failure)) damaged(name, failure);
  return turned(decoded.picture, decoded.orientation);
}

}  // namespace repose::dem_adapter
