#include "parallel/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "repose/base/random.hpp"

namespace repose::dem {
namespace {

std::vector<double> numbers_of_all_sizes(std::size_t count) {
  RandomStream random(5);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i)
    numbers.push_back(random.normal() * std::pow(10.0, random.uniform(-12.0, 6.0)));
  return numbers;
}

double sum_of(const std::vector<double>& numbers) {
  ExactSum sum;
  for (const double number : numbers) sum.add(number);
  return sum.value();
}

TEST(ExactSum, HasTheSameBitsInAnyOrderAndInAnyParts) {
  std::vector<double> numbers = numbers_of_all_sizes(5000);
  const double expected = sum_of(numbers);
  RandomStream random(6);
  bool plain_sums_differ = false;
  double plain = 0.0;
  for (const double number : numbers) plain += number;
  for (int k = 0; k < 20; ++k) {
    random.shuffle(numbers);
    EXPECT_EQ(sum_of(numbers), expected);
    double now = 0.0;
    ExactSum parts[7], whole;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      now += numbers[i];
      parts[random.below(7)].add(numbers[i]);
    }
    for (const ExactSum& part : parts) whole.add(part);
    EXPECT_EQ(whole.value(), expected);
    plain_sums_differ = plain_sums_differ || now != plain;
  }
  EXPECT_TRUE(plain_sums_differ);  // else the numbers show nothing
}

TEST(ExactSum, IsTheSumToItsResolution) {
  const std::vector<double> numbers = numbers_of_all_sizes(5000);
  long double expected = 0.0L;
  for (const double number : numbers) expected += number;
  // Each term is cut by less than 2^-80; the rest is the rounding of long double and of the result.
  EXPECT_NEAR(sum_of(numbers), static_cast<double>(expected), 1e-9);
  EXPECT_EQ(sum_of({0.1, -0.1}), 0.0);
  EXPECT_EQ(sum_of({1e11, 1e-12, -1e11}), sum_of({1e-12}));
  EXPECT_NEAR(sum_of({1e-12}), 1e-12, 0x1p-80);
  EXPECT_EQ(sum_of({3.0, -4.5}), -1.5);
}

TEST(ExactSum, SurvivesStorage) {
  for (const double value : {0.0, 1.0, -1.0, 1e-20, -1e-20, 7.5e12, -7.5e12}) {
    ExactSum sum;
    for (int k = 0; k < 5; ++k) sum.add(value / 10.0);
    const ExactSum again(sum.parts());
    EXPECT_EQ(again.value(), sum.value());
    EXPECT_EQ(again.parts().high, sum.parts().high);
    EXPECT_EQ(again.parts().low, sum.parts().low);
  }
}

TEST(ExactSum, OfWhatItCannotHoldIsNoNumber) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, -2e12}) {
    ExactSum sum;
    sum.add(1.0);
    sum.add(bad);
    sum.add(1.0);
    EXPECT_TRUE(std::isnan(sum.value())) << bad;
    EXPECT_TRUE(std::isnan(ExactSum(sum.parts()).value())) << bad;
    ExactSum other;
    other.add(sum);
    EXPECT_TRUE(std::isnan(other.value())) << bad;
  }
  for (const double sign : {1.0, -1.0}) {
    ExactSum sum;
    for (int k = 0; k < 100; ++k) sum.add(sign * 0x1.fp39);
    EXPECT_TRUE(std::isnan(sum.value()));  // rather than a sum that has wrapped around
  }
}

}  // namespace
}  // namespace repose::dem
