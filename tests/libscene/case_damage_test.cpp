// Damaged case files: they are read, or refused with a message; nothing else happens.
#include <gtest/gtest.h>

#include <sstream>

#include "repose/base/error.hpp"
#include "sample_case.hpp"

namespace repose::scene {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// Counts the texts that were refused; one that is read must be a case that can be written.
struct Outcome {
  int read = 0;
  int refused = 0;
  void try_text(const std::string& text) {
    try {
      const Case c = parse_case(text, "damaged");
      EXPECT_TRUE(parse_case(case_text(c), "again") == c) << text;
      ++read;
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("damaged:")) << error.what();
      ++refused;
    }
  }
};

TEST(DamagedCase, WithAnyValueReplacedIsReadOrRefused) {
  const std::vector<std::string> lines = lines_of(case_text(sample_case()));
  Outcome outcome;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const auto equals = lines[l].find(" = ");
    if (equals == std::string::npos || lines[l].starts_with(" ")) continue;
    for (const char* value : {"nan", "-inf", "0", "-1", "1e308", "5e-324", "9223372036854775807",
                              "\"\"", "\"x\"", "true", "[]", "[0, 0, 0]", "[1e308, -1e308, nan]",
                              "[\"x\", \"x\"]", "{}", "[{}]", "[[]]"}) {
      std::vector<std::string> damaged = lines;
      damaged[l] = lines[l].substr(0, equals + 3) + value;
      outcome.try_text(joined(damaged));
    }
  }
  EXPECT_GT(outcome.refused, 1000);
  EXPECT_GT(outcome.read, 10);
}

TEST(DamagedCase, WithAnyLineGoneOrTwiceIsReadOrRefused) {
  const std::vector<std::string> lines = lines_of(case_text(sample_case()));
  Outcome outcome;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    std::vector<std::string> damaged = lines;
    damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(l));
    outcome.try_text(joined(damaged));
    damaged = lines;
    damaged.insert(damaged.begin() + static_cast<std::ptrdiff_t>(l), lines[l]);
    outcome.try_text(joined(damaged));
  }
  EXPECT_GT(outcome.refused, 200);
}

TEST(DamagedCase, CutOffAnywhereIsReadOrRefused) {
  const std::string text = case_text(sample_case());
  Outcome outcome;
  for (std::size_t end = 0; end < text.size(); end += 23) outcome.try_text(text.substr(0, end));
  EXPECT_GT(outcome.refused, 100);
}

}  // namespace
}  // namespace repose::scene
