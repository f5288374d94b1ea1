// A folder of its own for each test, and tables that hold every kind of value.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <string>

#include "repose/base/error.hpp"
#include "repose/table/table.hpp"

namespace repose::table {

class FolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("repose_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  std::ptrdiff_t files() const {
    return std::distance(std::filesystem::directory_iterator(folder_), {});
  }

 private:
  std::filesystem::path folder_;
};

/// The message of the exception of type E that `action` must throw.
template <class E>
std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

/// Doubles that are hard to keep, integers at both ends, texts that look like something else.
inline Table every_kind_of_value() {
  using Limits = std::numeric_limits<double>;
  Table table;
  table.add({.name = "mu_s_pp",
             .role = Role::factor,
             .range = FactorRange{1e-3, 1.0, Scale::log},
             .values = std::vector<double>{0.1, 1.0 / 3.0, -0.0, Limits::denorm_min(),
                                           Limits::max(), Limits::min(), 1e22}});
  table.add({.name = "mass_flow",
             .unit = "kg/s",
             .role = Role::response,
             .values = std::vector<double>{2.0, -3.0, 0.0, 123456789012345680.0, 5e-324, 1e16,
                                           0.1 + 0.2}});
  table.add({.name = "run",
             .role = Role::id,
             .values = std::vector<std::int64_t>{0, -1, 2, std::numeric_limits<std::int64_t>::max(),
                                                 std::numeric_limits<std::int64_t>::min(), 7, 8}});
  table.add({.name = "note, \"quoted\"",
             .role = Role::group,
             .values = std::vector<std::string>{"", "1", "nan", "a,b", "line\r\nbreak \"x\"",
                                                " Schüttwinkel 안식각 ", "plain"}});
  return table;
}

inline bool same_bits(const Values& a, const Values& b) {
  const auto* x = std::get_if<std::vector<double>>(&a);
  const auto* y = std::get_if<std::vector<double>>(&b);
  if (x == nullptr || y == nullptr) return a == b;
  return std::equal(x->begin(), x->end(), y->begin(), y->end(), [](double u, double v) {
    return std::bit_cast<std::uint64_t>(u) == std::bit_cast<std::uint64_t>(v);
  });
}

}  // namespace repose::table
