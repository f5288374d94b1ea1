#include "warning.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace repose::cli {

void print_warning(const std::string& sentence) {
  fmt::print(stderr, "\nrepose: {}\n", sentence);
}

}  // namespace repose::cli
