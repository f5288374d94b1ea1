// Cases with one thing wrong, and the words that must name it.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "repose/base/error.hpp"
#include "sample_case.hpp"

namespace repose::scene {

/// One change that makes the sample wrong, and words that the message must have.
struct Wrong {
  const char* what;
  std::function<void(Case&)> change;
  const char* words;
};

inline void expect_each_is_refused(const std::vector<Wrong>& all) {
  for (const Wrong& wrong : all) {
    Case c = sample_case();
    wrong.change(c);
    try {
      validate(c);
      ADD_FAILURE() << wrong.what << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(wrong.words), std::string::npos)
          << wrong.what << ": " << error.what();
    }
  }
}

inline Wall& wall_of(Case& c, const std::string& name) {
  return c.walls.at(static_cast<std::size_t>(walls_named(c, name).at(0)));
}
template <class ShapeKind>
ShapeKind& shape_of(Case& c, const std::string& name) {
  return std::get<ShapeKind>(wall_of(c, name).shape);
}

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace repose::scene
