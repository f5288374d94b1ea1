#include "repose/scene/stl_file.hpp"

#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"

namespace repose::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t kHeaderBytes = 84;  // 80 of comment, then the number of triangles
constexpr std::size_t kTriangleBytes = 50;
constexpr double kLargestCoordinate = 1e30;

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

bool same_word(std::string_view token, std::string_view word) {
  if (token.size() != word.size()) return false;
  for (std::size_t k = 0; k < word.size(); ++k)
    if (std::tolower(static_cast<unsigned char>(token[k])) != word[k]) return false;
  return true;
}

/// Words of a text and the line they stand in.
class Words {
 public:
  Words(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  /// The next word; empty at the end of the text.
  std::string_view next() {
    while (at_ < text_.size() && is_space(text_[at_])) {
      if (text_[at_] == '\n') ++line_;
      ++at_;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }
  void expect(std::string_view word, std::string_view context) {
    const std::string_view found = next();
    if (!same_word(found, word))
      fail("expected \"" + std::string(word) + "\" " + std::string(context), found);
  }
  double number(std::string_view context) {
    const std::string_view word = next();
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double value = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || error == std::errc::invalid_argument ||
        end != digits.data() + digits.size())
      fail("expected a number " + std::string(context), word);
    const bool underflows = error == std::errc::result_out_of_range &&
                            digits.find_first_of("eE") + 1 == digits.find_last_of('-');
    if (underflows) return 0.0;
    if (error != std::errc() || !(std::abs(value) <= kLargestCoordinate))
      fail("expected a finite number of at most 1e30 " + std::string(context), word);
    return value;
  }
  [[noreturn]] void fail(const std::string& expectation, std::string_view found) const {
    throw InputError(name_ + ":" + std::to_string(line_) + ": " + expectation + ", found " +
                     (found.empty() ? "the end of the file; it is cut off, export it again"
                                    : "\"" + std::string(found.substr(0, 40)) + "\""));
  }

 private:
  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  std::int64_t line_ = 1;
};

/// "facet" has been read.
Triangle parse_facet(Words& words) {
  words.expect("normal", "after \"facet\"");
  for (int k = 0; k < 3; ++k) words.next();  // not used, and exporters write nan for slivers
  words.expect("outer", "after the normal of a facet");
  words.expect("loop", "after \"outer\"");
  Triangle triangle;
  for (Vec3& corner : triangle) {
    words.expect("vertex", "in a facet, which has three");
    for (int k = 0; k < 3; ++k) corner[k] = words.number("after \"vertex\"");
  }
  words.expect("endloop", "after three vertices: only triangles are read");
  words.expect("endfacet", "after \"endloop\"");
  return triangle;
}

std::vector<Triangle> parse_ascii(std::string_view text, const std::string& name) {
  Words words(text, name);
  std::vector<Triangle> triangles;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (!same_word(word, "solid")) words.fail("expected \"solid\"", word);
    words.skip_line();  // its name
    for (word = words.next(); same_word(word, "facet"); word = words.next())
      triangles.push_back(parse_facet(words));
    if (!same_word(word, "endsolid")) words.fail("expected \"facet\" or \"endsolid\"", word);
    words.skip_line();
  }
  return triangles;
}

std::vector<Triangle> parse_binary(std::string_view bytes, const std::string& name) {
  const std::size_t count = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  std::vector<Triangle> triangles(count);
  for (std::size_t t = 0; t < count; ++t) {
    float values[12];
    std::memcpy(values, bytes.data() + kHeaderBytes + t * kTriangleBytes, sizeof values);
    for (std::size_t k = 3; k < 12; ++k) {  // the first three are the normal
      const auto value = static_cast<double>(values[k]);
      if (!(std::abs(value) <= kLargestCoordinate))
        throw InputError(name + ": triangle " + std::to_string(t + 1) + " of " +
                         std::to_string(count) + " has a corner with the coordinate " +
                         std::to_string(value) + "; it must be finite and at most 1e30");
      triangles[t][(k - 3) / 3][static_cast<Eigen::Index>(k % 3)] = value;
    }
  }
  return triangles;
}

std::uint32_t announced_triangles(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

bool has_announced_size(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + kTriangleBytes * std::size_t{announced_triangles(bytes)};
}

bool begins_with_solid(std::string_view bytes) {
  std::size_t at = bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0;  // a byte order mark
  while (at < bytes.size() && is_space(bytes[at])) ++at;
  return same_word(bytes.substr(at, 5), "solid");
}

/// Whether the first kilobyte holds bytes that no text has.
bool has_control_bytes(std::string_view bytes) {
  for (const char c : bytes.substr(0, 1024))
    if (static_cast<unsigned char>(c) < 0x20 && !is_space(c)) return true;
  return false;
}

}  // namespace

std::vector<Triangle> parse_stl(std::string_view bytes, const std::string& name) {
  if (has_announced_size(bytes)) return parse_binary(bytes, name);
  if (begins_with_solid(bytes) && !has_control_bytes(bytes))
    return parse_ascii(bytes.substr(bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0), name);
  if (bytes.size() < kHeaderBytes)
    throw InputError(name + ": " + std::to_string(bytes.size()) +
                     " bytes are no STL file: neither text that begins with \"solid\" nor a "
                     "binary file, whose header alone takes 84");
  const std::size_t count = announced_triangles(bytes);
  throw InputError(name + ": a binary STL file of " + std::to_string(count) + " triangles takes " +
                   std::to_string(kHeaderBytes + kTriangleBytes * count) +
                   " bytes, but this one has " + std::to_string(bytes.size()) +
                   "; it is cut off, damaged or of another format: export it again");
}

std::vector<Triangle> read_stl(const std::filesystem::path& path) {
  return parse_stl(read_file(path), path.string());
}

}  // namespace repose::scene
