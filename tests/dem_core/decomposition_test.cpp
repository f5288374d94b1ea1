#include "parallel/decomposition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "repose/base/random.hpp"
#include "two_bodies.hpp"

namespace repose::dem {
namespace {

Box box_of(const Vec3& extent, const scene::Periodic& periodic = {}) {
  scene::Case c;
  c.lower_m.setZero();
  c.upper_m = extent;
  c.periodic = periodic;
  return Box(c);
}

/// Denser towards the floor, dearer in one corner.
std::vector<WeightedPoint> heap(const Vec3& extent, std::size_t count) {
  RandomStream random(11);
  std::vector<WeightedPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 x(random.uniform() * extent.x(), random.uniform() * extent.y(),
                 random.uniform() * random.uniform() * extent.z());
    points.push_back({x, x.x() < 0.3 * extent.x() ? 500 : 100});
  }
  return points;
}

TEST(Decomposition, GivesEachRankItsShareOfTheCost) {
  const Vec3 extent(0.4, 0.3, 1.0);
  const Box box = box_of(extent);
  const std::vector<WeightedPoint> points = heap(extent, 20000);
  double total = 0.0;
  for (const WeightedPoint& point : points) total += static_cast<double>(point.cost);
  for (const int ranks : {1, 2, 3, 4, 7, 16, 33}) {
    const Decomposition cut(box, points, ranks, Communicator());
    std::vector<double> cost(static_cast<std::size_t>(ranks), 0.0);
    for (const WeightedPoint& point : points)
      cost[static_cast<std::size_t>(cut.owner_of(point.x))] += static_cast<double>(point.cost);
    // Cuts are exact to 1/65536 of a side and to one point; ranks see up to six cuts.
    for (const double of_rank : cost)
      EXPECT_NEAR(of_rank * ranks / total, 1.0, ranks * 6 * (500.0 / total + 3e-5)) << ranks;
  }
}

TEST(Decomposition, OwnersAreThoseWhosePartHoldsThePoint) {
  const Vec3 extent(0.4, 0.3, 1.0);
  const Box box = box_of(extent);
  const Decomposition cut(box, heap(extent, 3000), 13, Communicator());
  RandomStream random(2);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 x(random.uniform() * 0.4, random.uniform() * 0.3, random.uniform());
    int holders = 0;
    for (int rank = 0; rank < 13; ++rank) {
      const Decomposition::Part part = cut.part_of(box, rank);
      const bool holds =
          (x.array() >= part.lower.array()).all() && (x.array() < part.upper.array()).all();
      EXPECT_EQ(holds, cut.owner_of(x) == rank);
      holders += holds ? 1 : 0;
    }
    EXPECT_EQ(holders, 1);
  }
}

TEST(Decomposition, CutsAcrossTheLongestSideButNotTwiceThroughAPeriod) {
  const auto axis_of_cut = [](const Vec3& extent, const scene::Periodic& periodic) {
    const Box box = box_of(extent, periodic);
    std::vector<WeightedPoint> points;
    RandomStream random(3);
    for (int k = 0; k < 4000; ++k)
      points.push_back(
          {Vec3(random.uniform(), random.uniform(), random.uniform()).cwiseProduct(extent), 1});
    const Decomposition cut(box, points, 2, Communicator());
    const Decomposition::Part part = cut.part_of(box, 0);
    for (int k = 0; k < 3; ++k)
      if (part.upper[k] < extent[k]) return k;
    return -1;
  };
  EXPECT_EQ(axis_of_cut({1.0, 0.4, 0.5}, {}), 0);
  EXPECT_EQ(axis_of_cut({0.3, 0.4, 0.5}, {}), 2);
  EXPECT_EQ(axis_of_cut({0.3, 0.4, 0.5}, {.z = true}), 1);   // 0.5 < 2 x 0.4
  EXPECT_EQ(axis_of_cut({0.3, 0.4, 0.95}, {.z = true}), 2);  // 0.95 > 2 x 0.4
}

TEST(Decomposition, KnowsTheRanksWithinADistance) {
  const Vec3 extent(0.4, 0.3, 1.0);
  const Box box = box_of(extent);
  const Decomposition cut(box, heap(extent, 3000), 13, Communicator());
  RandomStream random(4);
  for (int k = 0; k < 500; ++k) {
    const Vec3 x(random.uniform() * 0.4, random.uniform() * 0.3, random.uniform());
    std::vector<int> found, expected;
    cut.add_ranks_within(x, 0.07, found);
    std::sort(found.begin(), found.end());
    for (int rank = 0; rank < 13; ++rank) {
      const Decomposition::Part part = cut.part_of(box, rank);
      const Vec3 nearest = x.cwiseMax(part.lower).cwiseMin(part.upper);
      if ((x - nearest).norm() < 0.07) expected.push_back(rank);
    }
    EXPECT_EQ(found, expected);
  }
}

TEST(Decomposition, HasARankForEveryPlaceWithoutBodies) {
  const Box box = box_of({1, 1, 1});
  for (const std::size_t bodies : {0u, 1u, 2u}) {
    const std::vector<WeightedPoint> points(bodies, {Vec3(0.5, 0.5, 0.5), 10});
    const Decomposition cut(box, points, 4, Communicator());
    for (const double x : {0.1, 0.5, 0.9}) {
      const int owner = cut.owner_of({x, x, x});
      EXPECT_GE(owner, 0);
      EXPECT_LT(owner, 4);
    }
  }
}

}  // namespace
}  // namespace repose::dem
