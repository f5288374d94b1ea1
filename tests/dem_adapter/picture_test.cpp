// Picture files of all kinds, whole and damaged, and colours.
#include "repose/dem_adapter/picture.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>

#include "drawn_picture.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

Picture random_picture(int width, int height) {
  Picture picture(width, height);
  RandomStream random(8);
  for (Rgb& pixel : picture.pixels)
    for (auto& channel : pixel) channel = static_cast<std::uint8_t>(random.below(256));
  return picture;
}

/// Four plain quarters, which JPEG keeps: red, green / blue, white.
Picture quarters(int width, int height) {
  Picture picture(width, height);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column)
      picture.at(column, row) = row < height / 2
                                    ? (column < width / 2 ? Rgb{255, 0, 0} : Rgb{0, 255, 0})
                                    : (column < width / 2 ? Rgb{0, 0, 255} : Rgb{255, 255, 255});
  return picture;
}

std::string refusal(const std::filesystem::path& path) {
  try {
    read_picture(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// A PNG file by libpng from any of its formats.
std::string encoded(png_uint_32 width, png_uint_32 height, png_uint_32 format, const void* data) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, data, 0, nullptr), 0);
  bytes.resize(size);
  return bytes;
}

TEST(PictureFile, PngComesBackBitForBit) {
  const test::TemporaryDirectory directory;
  const auto picture = random_picture(31, 17);
  test::write_bytes(directory / "p", png_of(picture));  // the name does not matter
  const auto again = read_picture(directory / "p");
  EXPECT_EQ(again.width, 31);
  EXPECT_EQ(again.height, 17);
  EXPECT_EQ(again.pixels, picture.pixels);
}

TEST(PictureFile, PngMayBeGreyOrTransparent) {
  const test::TemporaryDirectory directory;
  const std::vector<std::uint8_t> grey(20 * 16, 77);
  test::write_bytes(directory / "grey.png", encoded(20, 16, PNG_FORMAT_GRAY, grey.data()));
  EXPECT_EQ(read_picture(directory / "grey.png").at(3, 3), (Rgb{77, 77, 77}));
  const std::vector<std::uint8_t> clear(20 * 16 * 4, 0);
  test::write_bytes(directory / "clear.png", encoded(20, 16, PNG_FORMAT_RGBA, clear.data()));
  EXPECT_EQ(read_picture(directory / "clear.png").at(3, 3), (Rgb{255, 255, 255}));
}

/// Without the chunk of this name: four bytes of length, the name, the data, four of a checksum.
std::string without_chunk(std::string png, const std::string& name) {
  const auto at = png.find(name);
  EXPECT_NE(at, std::string::npos) << name;
  std::size_t length = 0;
  for (std::size_t i = at - 4; i < at; ++i)
    length = length << 8 | static_cast<std::uint8_t>(png[i]);
  return png.erase(at - 4, length + 12);
}

TEST(PictureFile, SixteenBitsAreSRgbUnlessTheFileSaysThatTheyAreLight) {
  const test::TemporaryDirectory directory;
  const std::vector<std::uint16_t> grey(20 * 16, 0x8080);                       // 128 of 255
  const std::string light = encoded(20, 16, PNG_FORMAT_LINEAR_Y, grey.data());  // writes gAMA
  test::write_bytes(directory / "light.png", light);
  // 255 * (0x8080 / 0xFFFF)^(1 / 2.2): libpng's power for the curve of sRGB, which gives 188.
  EXPECT_EQ(read_picture(directory / "light.png").at(3, 3), (Rgb{186, 186, 186}));
  test::write_bytes(directory / "plain.png", without_chunk(light, "gAMA"));
  EXPECT_EQ(read_picture(directory / "plain.png").at(3, 3), (Rgb{128, 128, 128}));
}

TEST(PictureFile, JpegIsTurnedAsTheCameraWasHeld) {
  const test::TemporaryDirectory directory;
  // EXIF 2.3, table of orientations: where row 0 and column 0 of the file are seen.
  const auto upright = quarters(64, 32);
  const auto seen = [&](int orientation) {
    test::write_bytes(directory / "p.jpg", test::jpeg_of(upright, 95, orientation));
    return read_picture(directory / "p.jpg");
  };
  const auto name = [](const Rgb& p) {
    return p[0] > 128 ? (p[1] > 128 ? 'w' : 'r') : (p[1] > 128 ? 'g' : 'b');
  };
  const auto corners = [&](const Picture& p) {
    return std::string{name(p.at(4, 4)), name(p.at(p.width - 5, 4)), name(p.at(4, p.height - 5)),
                       name(p.at(p.width - 5, p.height - 5))};
  };
  EXPECT_EQ(corners(seen(0)), "rgbw");
  EXPECT_EQ(corners(seen(1)), "rgbw");
  EXPECT_EQ(corners(seen(2)), "grwb");  // mirrored left to right
  EXPECT_EQ(corners(seen(3)), "wbgr");  // upside down
  EXPECT_EQ(corners(seen(4)), "bwrg");  // mirrored top to bottom
  EXPECT_EQ(corners(seen(5)), "rbgw");  // transposed
  EXPECT_EQ(corners(seen(6)), "brwg");  // a quarter turn clockwise
  EXPECT_EQ(corners(seen(7)), "wgbr");
  EXPECT_EQ(corners(seen(8)), "gwrb");  // a quarter turn back
  EXPECT_EQ(seen(6).width, 32);
  EXPECT_EQ(corners(seen(9)), "rgbw");  // no such orientation
}

TEST(PictureFile, DamageIsASentence) {
  const test::TemporaryDirectory directory;
  const std::string png = png_of(random_picture(40, 40));
  const std::string jpeg = test::jpeg_of(quarters(64, 64), 90);
  test::write_bytes(directory / "empty.png", "");
  EXPECT_NE(refusal(directory / "empty.png").find("is empty; save the photograph as PNG or JPEG"),
            std::string::npos);
  test::write_bytes(directory / "text.png", "P6 16 16 255");
  EXPECT_NE(refusal(directory / "text.png").find("neither a PNG nor a JPEG"), std::string::npos);
  test::write_bytes(directory / "half.png", png.substr(0, png.size() / 2));
  EXPECT_NE(refusal(directory / "half.png").find("damaged PNG"), std::string::npos);
  test::write_bytes(directory / "half.jpg", jpeg.substr(0, jpeg.size() / 2));
  EXPECT_NE(refusal(directory / "half.jpg").find("damaged JPEG"), std::string::npos);
  test::write_bytes(directory / "print.jpg", test::cmyk_jpeg(32, 32));
  EXPECT_NE(refusal(directory / "print.jpg").find("(CMYK); save it as RGB"), std::string::npos)
      << refusal(directory / "print.jpg");
  test::write_bytes(directory / "small.png", png_of(random_picture(15, 40)));
  EXPECT_NE(refusal(directory / "small.png").find("15 x 40 pixels; at least 16 x 16"),
            std::string::npos);
  EXPECT_THROW(read_picture(directory / "missing.png"), StorageError);
}

TEST(PictureFile, AHeaderThatPromisesTooMuchIsRefusedBeforeAnythingIsAllocated) {
  const test::TemporaryDirectory directory;
  std::string png = png_of(random_picture(40, 40));
  // Width and height of IHDR, then its checksum, which libpng checks.
  for (const std::size_t at : {16U, 20U}) png.replace(at, 4, std::string("\x00\x04\x00\x00", 4));
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<std::uint8_t>(png[i]);
    for (int k = 0; k < 8; ++k) crc = crc & 1U ? crc >> 1 ^ 0xEDB88320U : crc >> 1;
  }
  for (std::size_t k = 0; k < 4; ++k) png[29 + k] = static_cast<char>(~crc >> (24 - 8 * k));
  test::write_bytes(directory / "huge.png", png);
  EXPECT_NE(refusal(directory / "huge.png").find("262144 x 262144 pixels, more than 100 million"),
            std::string::npos)
      << refusal(directory / "huge.png");
}

TEST(PictureFile, NoByteThatIsWrongCrashesAReader) {
  const test::TemporaryDirectory directory;
  RandomStream random(3);
  for (const std::string& good :
       {png_of(random_picture(20, 20)), test::jpeg_of(quarters(32, 32), 80, 6)})
    for (int i = 0; i < 400; ++i) {
      std::string bad = good;
      bad[random.below(bad.size())] = static_cast<char>(random.below(256));
      if (i % 4 == 0) bad.resize(random.below(bad.size()));
      test::write_bytes(directory / "bad", bad);
      try {
        const auto picture = read_picture(directory / "bad");
        EXPECT_EQ(picture.pixels.size(), static_cast<std::size_t>(picture.width) *
                                             static_cast<std::size_t>(picture.height));
      } catch (const InputError& error) {
        EXPECT_GT(std::strlen(error.what()), 30U);
      }
    }
}

TEST(Level, OfNoTiltIsThePictureItself) {
  const auto picture = random_picture(33, 20);
  EXPECT_EQ(leveled(picture, 0.0).pixels, picture.pixels);
}

TEST(Level, IsTheAngleOfTheLineThatFallsToTheRight) {
  EXPECT_NEAR(tilt_deg({0.0, 0.0}, {100.0, 10.0}), std::atan(0.1) * 180.0 / M_PI, 1e-12);
  EXPECT_NEAR(tilt_deg({100.0, 10.0}, {0.0, 0.0}), std::atan(0.1) * 180.0 / M_PI, 1e-12);
  EXPECT_LT(tilt_deg({0.0, 10.0}, {100.0, 0.0}), 0.0);
  EXPECT_THROW(tilt_deg({0.0, 0.0}, {15.0, 0.0}), InputError);
  EXPECT_THROW(tilt_deg({0.0, 0.0}, {100.0, 40.0}), InputError);
}

TEST(Crop, IsThePartThatIsNamedOrASentence) {
  const auto picture = random_picture(60, 50);
  const auto part = cropped(picture, {.column = 7, .row = 9, .width = 20, .height = 30});
  EXPECT_EQ(part.at(0, 0), picture.at(7, 9));
  EXPECT_EQ(part.at(19, 29), picture.at(26, 38));
  for (const PixelBox& box :
       {PixelBox{41, 0, 20, 20}, PixelBox{-1, 0, 20, 20}, PixelBox{0, 0, 20, 51},
        PixelBox{0, 0, 5, 20}, PixelBox{0, 0, 2147483647, 2147483647}})
    EXPECT_THROW(cropped(picture, box), InputError) << box.column << " " << box.width;
}

TEST(Lab, OfPrimariesIsThatOfTheTables) {
  // sRGB primaries in CIELAB under D65, to the two decimals that are published (Lindbloom's
  // calculator gives the same): the matrix has four digits, an error of a few hundredths.
  const auto near = [](Rgb rgb, double l, double a, double b) {
    const Lab lab = lab_of(rgb);
    EXPECT_NEAR(lab.l, l, 0.05);
    EXPECT_NEAR(lab.a, a, 0.05);
    EXPECT_NEAR(lab.b, b, 0.05);
  };
  near({255, 255, 255}, 100.0, 0.0, 0.0);
  near({0, 0, 0}, 0.0, 0.0, 0.0);
  near({255, 0, 0}, 53.24, 80.09, 67.20);
  near({0, 255, 0}, 87.73, -86.18, 83.18);
  near({0, 0, 255}, 32.30, 79.19, -107.86);
  near({119, 119, 119}, 50.03, 0.0, 0.0);
}

TEST(Color, IsReadFromSixDigits) {
  EXPECT_EQ(parse_color("#c0A080"), (Rgb{192, 160, 128}));
  EXPECT_EQ(parse_color("000001"), (Rgb{0, 0, 1}));
  for (const char* wrong : {"", "#", "#12345", "#1234567", "red", "#12345g", "#-12345"})
    EXPECT_THROW(parse_color(wrong), InputError) << wrong;
}

}  // namespace
}  // namespace repose::dem_adapter
