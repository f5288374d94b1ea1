#include "repose/dem_adapter/picture.hpp"

#include <fmt/format.h>

#include <charconv>

#include "formats.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::uintmax_t kMostBytes = 1'000'000'000;
constexpr int kLeastPixels = 16;  // a side

}  // namespace

Picture::Picture(int columns, int rows, Rgb fill)
    : width(columns),
      height(rows),
      pixels(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), fill) {}

void check_size(const std::string& name, std::size_t width, std::size_t height) {
  if (width < kLeastPixels || height < kLeastPixels)
    throw InputError(fmt::format("'{}' has {} x {} pixels; at least {} x {} are needed", name,
                                 width, height, kLeastPixels, kLeastPixels));
  if (width > kMostPixels / height)
    throw InputError(fmt::format("'{}' has {} x {} pixels, more than {} million; shrink or crop it",
                                 name, width, height, kMostPixels / 1'000'000));
}

Picture read_picture(const std::filesystem::path& path) {
  std::error_code code;
  if (const auto bytes = std::filesystem::file_size(path, code); !code && bytes > kMostBytes)
    throw InputError(fmt::format("'{}' has {} bytes, more than a picture may have ({}); shrink it",
                                 path.string(), bytes, kMostBytes));
  const std::string bytes = read_file(path);
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return read_png(bytes, path.string());
  if (bytes.starts_with("\xff\xd8\xff")) return read_jpeg(bytes, path.string());
  throw InputError(fmt::format("'{}' is {}; save the photograph as PNG or JPEG", path.string(),
                               bytes.empty() ? "empty" : "neither a PNG nor a JPEG file"));
}

Picture cropped(const Picture& picture, const PixelBox& box) {
  if (box.column < 0 || box.row < 0 || box.width < kLeastPixels || box.height < kLeastPixels ||
      box.column > picture.width - box.width || box.row > picture.height - box.height)
    throw InputError(fmt::format(
        "the crop of {} x {} pixels at column {}, row {} does not lie within the picture of {} x "
        "{}, or is smaller than {} x {}",
        box.width, box.height, box.column, box.row, picture.width, picture.height, kLeastPixels,
        kLeastPixels));
  Picture part(box.width, box.height);
  for (int row = 0; row < box.height; ++row)
    for (int column = 0; column < box.width; ++column)
      part.at(column, row) = picture.at(box.column + column, box.row + row);
  return part;
}

Rgb parse_color(std::string_view text) {
  const std::string_view digits = text.starts_with('#') ? text.substr(1) : text;
  std::uint32_t value = 0;
  const auto [stop, code] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (digits.size() != 6 || code != std::errc{} || stop != digits.data() + digits.size())
    throw InputError(
        fmt::format("the colour '{}' is not six hexadecimal digits; write it like #c0a080", text));
  return {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
          static_cast<std::uint8_t>(value)};
}

}  // namespace repose::dem_adapter
