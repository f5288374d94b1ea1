// Neighbor lists against the search of all pairs, and what rebuilding must not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "neighbor/neighbor_lists.hpp"
#include "repose/base/random.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

using Pairs = std::set<std::pair<std::int32_t, std::int32_t>>;

Spheres random_spheres(const Box& box, std::size_t n, double smallest, double largest,
                       std::uint64_t seed) {
  RandomStream random(seed);
  Spheres spheres;
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 x;
    for (int k = 0; k < 3; ++k) x[k] = random.uniform(box.lower[k], box.upper[k]);
    const double radius = random.uniform(smallest, largest);
    const auto id = static_cast<std::int32_t>(i);
    spheres.add({.motion = {x, radius, Vec3::Zero(), 1.0}, .id = id, .body = id, .mass = 1.0});
  }
  return spheres;
}

Pairs all_pairs(const Box& box, double skin, const Spheres& spheres) {
  Pairs pairs;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t j = i + 1; j < spheres.size(); ++j) {
      const Vec3 d = box.nearest_image(spheres.motion[j].x - spheres.motion[i].x);
      if (d.norm() < spheres.motion[i].radius + spheres.motion[j].radius + skin)
        pairs.insert(std::minmax(spheres.id[i], spheres.id[j]));
    }
  return pairs;
}

Pairs listed(const NeighborList& list, const Spheres& spheres) {
  Pairs pairs;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    std::int32_t before = static_cast<std::int32_t>(i);
    for (std::int32_t p = list.first[i]; p < list.first[i + 1]; ++p) {
      const std::int32_t j = list.entries[static_cast<std::size_t>(p)].other;
      EXPECT_GT(j, before);  // ascending: the order of every sum
      before = j;
      pairs.insert(std::minmax(spheres.id[i], spheres.id[static_cast<std::size_t>(j)]));
    }
  }
  EXPECT_EQ(pairs.size(), list.entries.size());  // each pair once
  return pairs;
}

TEST(NeighborList, HoldsTheSamePairsAsTheSearchOfAll) {
  // Boxes with 1, 2, 3 and many cells along periodic directions, and without any.
  struct Setup {
    Vec3 extent;
    scene::Periodic periodic;
    double largest;
  };
  const scene::Periodic none{};
  const scene::Periodic y{.x = false, .y = true, .z = false};
  const scene::Periodic all{.x = true, .y = true, .z = true};
  std::uint64_t seed = 1;
  for (const Setup& s :
       {Setup{{1, 1, 1}, none, 0.05}, Setup{{1, 0.21, 2}, y, 0.05}, Setup{{1, 0.28, 2}, y, 0.05},
        Setup{{1, 0.4, 1}, y, 0.05}, Setup{{1, 1, 1}, all, 0.04}, Setup{{0.2, 0.3, 0.4}, all, 0.05},
        Setup{{1, 1, 1}, none, 0.2}, Setup{{1000, 1, 1000}, none, 0.01}}) {
    scene::Case c = empty_case({});
    c.lower_m.setZero();
    c.upper_m = s.extent;
    c.periodic = s.periodic;
    const Box box(c);
    for (double skin : {0.0, 0.013, 0.05}) {
      Spheres spheres = random_spheres(box, 600, 0.1 * s.largest, s.largest, seed++);
      NeighborLists lists;
      ContactPool pool;
      WallContacts wall_contacts;
      Clumps clumps;
      rebuild(box, skin, Walls(c), spheres, clumps, lists, pool, wall_contacts);
      EXPECT_EQ(listed(lists.pairs, spheres), all_pairs(box, skin, spheres));
    }
  }
}

TEST(NeighborList, CarriesHistoryThroughANewOrder) {
  // Each contact remembers who is who; after the spheres have moved elsewhere and were sorted anew
  // the history of (i, j) must be the same, or its opposite where j now comes first.
  scene::Case c = empty_case({});
  c.lower_m.setZero();
  c.upper_m.setConstant(1.0);
  const Box box(c);
  Spheres spheres = random_spheres(box, 400, 0.03, 0.05, 7);
  NeighborLists lists;
  ContactPool pool;
  WallContacts wall_contacts;
  Clumps clumps;
  rebuild(box, 0.02, Walls(c), spheres, clumps, lists, pool, wall_contacts);
  const auto signature = [](std::int32_t a, std::int32_t b) { return Vec3(1.0 + a, 1.0 + b, 1.0); };
  std::size_t contacts = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::int32_t p = lists.pairs.first[i]; p < lists.pairs.first[i + 1]; ++p) {
      Neighbor& neighbor = lists.pairs.entries[static_cast<std::size_t>(p)];
      const auto j = static_cast<std::size_t>(neighbor.other);
      if ((spheres.motion[i].x - spheres.motion[j].x).norm() >
          spheres.motion[i].radius + spheres.motion[j].radius)
        continue;
      neighbor.contact = pool.begin_contact();
      const std::int32_t a = spheres.id[i];
      const std::int32_t b = spheres.id[j];
      pool.at(neighbor.contact).history.slip = a < b ? signature(a, b) : Vec3(-signature(b, a));
      ++contacts;
    }
  ASSERT_GT(contacts, 100u);
  for (Motion& sphere : spheres.motion) sphere.x = 1.0 * Vec3::Ones() - sphere.x;  // mirrored
  rebuild(box, 0.02, Walls(c), spheres, clumps, lists, pool, wall_contacts);
  EXPECT_EQ(pool.size(), contacts);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::int32_t p = lists.pairs.first[i]; p < lists.pairs.first[i + 1]; ++p) {
      const Neighbor& neighbor = lists.pairs.entries[static_cast<std::size_t>(p)];
      if (neighbor.contact == kNoContact) continue;
      const std::int32_t a = spheres.id[i];
      const std::int32_t b = spheres.id[static_cast<std::size_t>(neighbor.other)];
      const Vec3 expected = a < b ? signature(a, b) : Vec3(-signature(b, a));
      EXPECT_EQ(pool.at(neighbor.contact).history.slip, expected);
      ++seen;
    }
  EXPECT_EQ(seen, contacts);
}

TEST(NeighborList, SkinDoesNotChangeThePhysics) {
  // A dense splash of a few spheres; lists built at every step and lists built rarely hold the same
  // contacts, so that only the order of sums differs: rounding, amplified by a few collisions.
  const auto run = [](double skin) {
    scene::Case c = empty_case({.mu_s = 0.5, .mu_r = 0.1});
    c.gravity_m_s2.z() = -9.81;
    c.lower_m.setConstant(-0.5);
    c.upper_m.setConstant(0.5);
    c.walls = scene::box_walls("bin", "wall", {-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, {"+z"});
    c.fill = scene::Fill{{-0.03, -0.03, 0},
                         {0.03, 0.03, 0.2},
                         0.25,
                         {layer_of("grain", 0.15, {{0.008, 0.012, 1.0}})}};
    Simulation sim(c, {.skin_radii = skin});
    while (sim.time_s() < 0.06) sim.step();
    EXPECT_GT(sim.contacts(), 5u);
    return std::pair{sim.kinetic_energy_j(), sim.rebuilds()};
  };
  const auto often = run(0.02);
  const auto rarely = run(2.0);
  EXPECT_GT(often.second, 5 * rarely.second);
  EXPECT_NEAR(often.first, rarely.first, 1e-9 * rarely.first);
}

}  // namespace
}  // namespace repose::dem
