// Indices of segregation at their limits, in random mixtures, and over time.
#include "repose/dem_adapter/segregation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::dem_adapter {
namespace {

/// `bins` bins of `per_bin` grains along x, one bin a metre; the first `share` of all grains are of
/// component 0. Grains have mass 1 kg, those of component 1 mass `other_kg`; volume 1e-3 of it.
Mixture row_of_grains(int bins, int per_bin, double share, double other_kg = 1.0) {
  Mixture mixture{.components = {"tracer", "rest"}};
  const int n = bins * per_bin;
  for (int i = 0; i < n; ++i) {
    mixture.component.push_back(i < share * n ? 0 : 1);
    mixture.position.push_back({(i + 0.5) / per_bin, 0.0, 0.0});
    mixture.mass_kg.push_back(mixture.component.back() == 0 ? 1.0 : other_kg);
    mixture.volume_m3.push_back(1e-3 * mixture.mass_kg.back());
  }
  return mixture;
}

/// The same grains in random places.
Mixture shuffled(Mixture mixture, RandomStream& random) {
  random.shuffle(mixture.position);
  return mixture;
}

const Grid kMetres{.kind = GridKind::x, .size = 1.0};

TEST(RelativeDeviation, OfPureBinsIsTheLargestThereIs) {
  for (const int m : {4, 20})
    for (const double p : {0.25, 0.5, 0.75}) {
      const auto bins = bins_of(row_of_grains(m, 10, p), kMetres);
      const auto rsd = relative_deviations(bins.mass_kg);
      EXPECT_NEAR(rsd[0].mean, p, 1e-14);
      EXPECT_NEAR(rsd[0].rsd(), std::sqrt(m / (m - 1.0) * (1.0 - p) / p), 1e-13);
      EXPECT_NEAR(rsd[1].rsd(), std::sqrt(m / (m - 1.0) * p / (1.0 - p)), 1e-13);
      EXPECT_NEAR(rsd[0].deviation, rsd[1].deviation, 1e-14);  // two components mirror each other
    }
}

TEST(RelativeDeviation, OfBinsAllAlikeIsZero) {
  Eigen::MatrixXd amounts(5, 3);
  for (int j = 0; j < 5; ++j) amounts.row(j) << 1.0 * (j + 1), 2.0 * (j + 1), 5.0 * (j + 1);
  for (const auto& deviation : relative_deviations(amounts))
    EXPECT_NEAR(deviation.rsd(), 0.0, 1e-15);
}

TEST(RelativeDeviation, DoesNotDependOnUnitsOrTheOrderOfBins) {
  RandomStream random(3);
  Eigen::MatrixXd amounts(12, 2);
  for (int j = 0; j < 12; ++j) amounts.row(j) << random.uniform(), random.uniform();
  const auto plain = relative_deviations(amounts);
  const auto scaled = relative_deviations(amounts * 1000.0);
  const auto reversed = relative_deviations(amounts.colwise().reverse().eval());
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(scaled[k].rsd(), plain[k].rsd(), 1e-13);
    EXPECT_NEAR(reversed[k].rsd(), plain[k].rsd(), 1e-13);
  }
}

TEST(RelativeDeviation, OfOneBinIsRefused) {
  EXPECT_THROW(relative_deviations(Eigen::MatrixXd::Ones(1, 2)), InputError);
}

/// Mean of the squared deviation over many random mixtures, over its expectation.
double ratio_of_variances(const Mixture& mixture, Basis basis, double size, int repetitions) {
  RandomStream random(21);
  double sum = 0.0, expected = 0.0;
  for (int i = 0; i < repetitions; ++i) {
    const auto bins = bins_of(shuffled(mixture, random), {.kind = GridKind::x, .size = size});
    sum += std::pow(relative_deviations(bins.amount(basis))[0].deviation, 2);
    expected = std::pow(random_deviation(mixture, 0, basis, bins.number), 2);
  }
  return sum / repetitions / expected;
}

TEST(RandomMixture, HasTheDeviationThatChanceGives) {
  // The variance over m bins scatters by sqrt(2 / (m - 1)) of itself; R repetitions, four standard
  // errors: a false alarm in 16,000.
  constexpr int kBins = 20, kRepetitions = 2000;
  const double four = 4.0 * std::sqrt(2.0 / (kBins - 1.0) / kRepetitions);
  const auto equal = row_of_grains(kBins, 15, 0.3);
  EXPECT_NEAR(ratio_of_variances(equal, Basis::number, 1.0, kRepetitions), 1.0, four);
  // Tracers four times as heavy, by mass: to first order in 1 / N_j, here 1 / 60.
  const auto heavy = row_of_grains(kBins, 60, 0.3, 0.25);
  EXPECT_NEAR(ratio_of_variances(heavy, Basis::mass, 1.0, kRepetitions), 1.0, four + 4.0 / 60.0);
}

TEST(RandomMixture, HasTheExpectedIndexOfLi) {
  // Drawn without replacement: E[sum N^j / N (y^j - y)^2] / (y (1 - y)) = (m - 1) / (N - 1),
  // whatever the composition. The index is chi^2 with m - 1 degrees of freedom over N - 1.
  constexpr int kBins = 8, kRepetitions = 4000;
  for (const double share : {0.2, 0.5}) {
    const auto mixture = row_of_grains(kBins, 25, share);
    RandomStream random(9);
    double sum = 0.0;
    for (int i = 0; i < kRepetitions; ++i)
      sum += segregation_indices(bins_of(shuffled(mixture, random), kMetres), 0).li;
    const double expected = (kBins - 1.0) / (kBins * 25 - 1.0);
    EXPECT_NEAR(sum / kRepetitions / expected, 1.0,
                4.0 * std::sqrt(2.0 / (kBins - 1.0) / kRepetitions));
  }
}

TEST(RandomMixture, HasTheLaceyIndexOne) {
  constexpr int kBins = 20, kRepetitions = 1000;
  const auto mixture = row_of_grains(kBins, 30, 0.4);
  RandomStream random(2);
  double sum = 0.0;
  for (int i = 0; i < kRepetitions; ++i)
    sum += segregation_indices(bins_of(shuffled(mixture, random), kMetres), 0).variance_fraction;
  // s_r^2 / (s_0^2 - s_r^2) = 1 / 29 times the scatter of a variance; N / (N - 1) moves it by 6e-5.
  EXPECT_NEAR(sum / kRepetitions, 0.0, 4.0 / 29.0 * std::sqrt(2.0 / 19.0 / kRepetitions) + 6e-5);
}

TEST(SegregationIndices, OfPureBinsAreTheirUpperLimits) {
  for (const double p : {0.25, 0.5}) {
    constexpr double m = 12.0, n = 10.0;
    const auto i = segregation_indices(bins_of(row_of_grains(12, 10, p), kMetres), 0);
    EXPECT_NEAR(i.li, 1.0, 1e-14);
    EXPECT_NEAR(i.panda_tan, std::sqrt(p * (1.0 - p)), 1e-14);
    EXPECT_NEAR(i.ketterhagen, std::sqrt((1.0 - p) / p), 1e-13);
    EXPECT_NEAR(i.mantravadi_tan, std::sqrt(m / (m - 1.0) * (1.0 - p) / p), 1e-13);
    EXPECT_NEAR(i.variance_fraction, (m / (m - 1.0) - 1.0 / n) / (1.0 - 1.0 / n), 1e-13);
    EXPECT_NEAR(i.lacey, 1.0 - i.variance_fraction, 1e-15);
    EXPECT_EQ(i.ashton_valentin, 0.0);
  }
}

TEST(SegregationIndices, OfBinsAllAlikeAreTheirLowerLimits) {
  auto mixture = row_of_grains(10, 8, 0.5);
  for (std::size_t i = 0; i < mixture.size(); ++i) mixture.component[i] = static_cast<int>(i % 2);
  const auto index = segregation_indices(bins_of(mixture, kMetres), 1);
  EXPECT_EQ(index.li, 0.0);
  EXPECT_EQ(index.panda_tan, 0.0);
  EXPECT_EQ(index.ketterhagen, 0.0);
  EXPECT_EQ(index.mantravadi_tan, 0.0);
  EXPECT_NEAR(index.variance_fraction, -1.0 / 7.0, 1e-14);  // more even than chance
}

TEST(SegregationIndices, AreRefusedWhereTheySayNothing) {
  const auto mixture = row_of_grains(10, 8, 0.5);
  EXPECT_THROW(segregation_indices(bins_of(mixture, {.kind = GridKind::x, .size = 50.0}), 0),
               InputError);
  EXPECT_THROW(segregation_indices(bins_of(mixture, {.kind = GridKind::x, .size = 0.1}), 0),
               InputError);
  auto single = row_of_grains(10, 8, 1.0);
  single.components = {"tracer"};
  EXPECT_THROW(segregation_indices(bins_of(single, kMetres), 0), InputError);
}

TEST(NormalisedRatios, AverageToOneOverAllBins) {
  RandomStream random(31);
  const auto bins = bins_of(shuffled(row_of_grains(15, 12, 0.3), random), kMetres);
  const Eigen::MatrixXd ratio = normalised_ratios(bins.mass_kg);
  const Eigen::VectorXd mass = bins.mass_kg.rowwise().sum();
  const Eigen::VectorXd share = bins.mass_kg.colwise().sum().transpose() / mass.sum();
  for (Eigen::Index k = 0; k < 2; ++k) EXPECT_NEAR(ratio.col(k).dot(mass) / mass.sum(), 1.0, 1e-13);
  for (Eigen::Index j = 0; j < ratio.rows(); ++j)
    EXPECT_NEAR(ratio.row(j).dot(share.transpose()), 1.0, 1e-13);
}

TEST(FilledBins, LeaveOutTheRim) {
  auto mixture = row_of_grains(10, 8, 0.5);
  mixture.component.push_back(1);
  mixture.position.push_back({10.5, 0.0, 0.0});  // a bin of one grain
  mixture.mass_kg.push_back(1.0);
  mixture.volume_m3.push_back(1e-3);
  const auto bins = bins_of(mixture, kMetres);
  EXPECT_EQ(filled(bins, 0.0).cell.size(), 11U);
  const auto kept = filled(bins, 0.5);
  EXPECT_EQ(kept.cell.size(), 10U);
  EXPECT_EQ(kept.number.rows(), 10);
  EXPECT_EQ(kept.mass_kg.sum(), 80.0);
}

TEST(CenterOfMassShift, IsHalfTheDepthAtMost) {
  const auto layered = [](int on_top) {
    Mixture mixture{.components = {"a", "b"}};
    for (int i = 0; i < 1000; ++i) {
      mixture.component.push_back(i < 500 ? 1 - on_top : on_top);
      mixture.position.push_back({0.0, 0.0, (i + 0.5) / 1000.0});
      mixture.mass_kg.push_back(2.0);
    }
    return mixture;
  };
  const auto shift = center_of_mass_shifts(layered(1), layered(0));
  // Between the lowest and the highest centre lie 999 of the 1000 spacings.
  EXPECT_NEAR(shift.at("a"), 0.5 * 1000.0 / 999.0, 1e-12);
  EXPECT_NEAR(shift.at("b"), -0.5 * 1000.0 / 999.0, 1e-12);
  EXPECT_EQ(center_of_mass_shifts(layered(1), layered(1)).at("a"), 0.0);
  auto other = layered(0);
  other.components[1] = "c";
  EXPECT_EQ(center_of_mass_shifts(layered(1), other).size(), 1U);
  auto flat = layered(0);
  for (auto& x : flat.position) x.z() = 0.5;
  EXPECT_THROW(center_of_mass_shifts(flat, layered(0)), InputError);
  EXPECT_THROW(center_of_mass_shifts({}, layered(0)), InputError);
}

/// A stream that is all component 0, then mixed as in the hopper, then all component 1; 100 kg when
/// it is full, hardly anything before and after.
Composition stream() {
  Composition c;
  c.mass_kg.resize(50, 2);
  for (int i = 0; i < 50; ++i) {
    c.time_s.push_back(0.2 * i);
    const double total = i < 10 || i >= 40 ? 1.9 : 100.0;
    const double first = i < 20 ? 1.0 : i < 30 ? 0.25 : 0.0;
    c.mass_kg.row(i) << total * first, total * (1.0 - first);
  }
  return c;
}

TEST(SegregationOverTime, FollowsTheEquationsOfTheThesis) {
  const auto s = segregation_over_time(stream(), Eigen::Vector2d(0.25, 0.75));
  ASSERT_EQ(s.used.size(), 30U);  // 1.9 kg is below 2 % of 100 kg
  EXPECT_EQ(s.used.front(), 10U);
  EXPECT_EQ(s.normalised_time.front(), 0.0);
  EXPECT_NEAR(s.normalised_time[1], 1.0 / 29.0, 1e-12);
  EXPECT_NEAR(s.normalised_time.back(), 1.0, 1e-15);
  EXPECT_NEAR(s.index(5, 0), 1.0, 1e-15);                          // nothing but the tracer
  EXPECT_NEAR(s.index(15, 0), 0.0, 1e-15);                         // as in the hopper
  EXPECT_NEAR(s.index(25, 0), 0.25 / 0.75, 1e-15);                 // |0 - chi_0| / (1 - chi_0)
  EXPECT_NEAR(s.mean_index[0], (1.0 + 0.25 / 0.75) / 3.0, 1e-14);  // ten rows each
  EXPECT_NEAR(s.normalised_ratio(5, 0), 4.0, 1e-14);
  EXPECT_NEAR(s.normalised_ratio(15, 1), 1.0, 1e-14);
}

TEST(SegregationOverTime, WeighsRowsByTheTimeThatTheyStandFor) {
  // A sixth row right after the third, as the end of a stage adds one: the plain mean would be 2 /
  // 6 instead of 1 / 5.
  constexpr double kLate = 1e-6;
  Composition c{.time_s = {0.0, 1.0, 2.0, 2.0 + kLate, 3.0, 4.0}, .mass_kg = {}};
  c.mass_kg.resize(6, 2);
  c.mass_kg.setConstant(2.0);
  for (const int i : {2, 3}) c.mass_kg.row(i) << 4.0, 0.0;
  const auto s = segregation_over_time(c, Eigen::Vector2d(0.5, 0.5));
  ASSERT_EQ(s.used.size(), 6U);
  EXPECT_NEAR(s.mean_index[0], 0.2, kLate);
  // A gap below the 2 % does not lend its time to the rows beside it: SI 1 from 0 to 2 s, nothing
  // from 3 to 6 s, SI 0 from 7 to 8 s.
  Composition gap;
  gap.mass_kg.resize(9, 2);
  for (int i = 0; i < 9; ++i) {
    gap.time_s.push_back(i);
    gap.mass_kg.row(i) << (i < 3 ? 2.0 : i < 7 ? 0.0 : 1.0), (i < 7 ? 0.0 : 1.0);
  }
  const auto apart = segregation_over_time(gap, Eigen::Vector2d(0.5, 0.5));
  ASSERT_EQ(apart.used.size(), 5U);
  EXPECT_NEAR(apart.mean_index[0], 3.0 / 5.0, 1e-15);
}

TEST(SegregationOverTime, TakesTheLeastShareThatIsGiven) {
  const Eigen::Vector2d half(0.5, 0.5);
  EXPECT_EQ(segregation_over_time(stream(), half, {.least_share = 0.0}).used.size(), 50U);
  EXPECT_THROW(segregation_over_time(stream(), half, {.least_share = 1.0}), InputError);
  EXPECT_THROW(segregation_over_time(stream(), Eigen::Vector2d(0.0, 1.0)), InputError);
  EXPECT_THROW(segregation_over_time({{}, Eigen::MatrixXd(0, 2)}, half), InputError);
}

}  // namespace
}  // namespace repose::dem_adapter
