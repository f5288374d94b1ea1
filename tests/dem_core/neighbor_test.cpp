// Neighbor lists against the search of all pairs, and what rebuilding must not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mesh_walls.hpp"
#include "neighbor/neighbor_lists.hpp"
#include "neighbor/skin.hpp"
#include "neighbor/sphere_order.hpp"
#include "repose/base/random.hpp"

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
      order_by_place(box, spheres);
      const auto new_index = sort_spheres(spheres, clumps, wall_contacts);
      rebuild(box, skin, Walls(c), new_index, spheres, lists, pool);
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
  const auto build = [&] {
    order_by_place(box, spheres);
    const auto new_index = sort_spheres(spheres, clumps, wall_contacts);
    rebuild(box, 0.02, Walls(c), new_index, spheres, lists, pool);
  };
  build();
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
  build();
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

TEST(NeighborList, IsTheSameWhereSpheresKeepAnOrderThatIsNotTheirs) {
  scene::Case c = empty_case({});
  c.lower_m.setZero();
  c.upper_m.setConstant(1.0);
  c.periodic.x = true;
  const Box box(c);
  Spheres spheres = random_spheres(box, 500, 0.01, 0.08, 11);
  NeighborLists lists;
  ContactPool pool;
  const std::vector<std::int32_t> before = spheres.id;
  rebuild(box, 0.01, Walls(c), {}, spheres, lists, pool);
  EXPECT_EQ(spheres.id, before);
  EXPECT_EQ(listed(lists.pairs, spheres), all_pairs(box, 0.01, spheres));
}

TEST(WallList, HoldsTheFacetsBehindAPeriodicSide) {
  // A sphere slides over a mesh across the side of the domain; with lists that last for the whole
  // way it must meet the triangles on the other side all the same.
  const auto lowest = [](double skin) {
    scene::Case c = empty_case({.restitution = 0.3});
    c.gravity_m_s2.z() = -9.81;
    c.lower_m = {-1, -0.03, -1};
    c.upper_m = {1, 0.03, 1};
    c.periodic.y = true;
    c.walls = {mesh_wall("floor", floor_triangles(-0.04, 0.04, -0.03, 0.03, 8, 12))};
    c.particles = {grain(0.005, {0, 0.029, 0.00499}, {0, 0.2, 0})};
    Simulation sim(c, {.skin_radii = skin});
    double z = 1.0;
    while (sim.time_s() < 0.02) {
      sim.step(5);
      z = std::min(z, sim.spheres()[0].position.z());
    }
    EXPECT_LT(sim.spheres()[0].position.y(), 0.0);
    return z;
  };
  const double often = lowest(0.02);
  EXPECT_GT(often, 0.0049);
  EXPECT_EQ(lowest(1.9), often);
}

TEST(SphereOrder, OfTwoSpheresDependsOnTheseTwoAlone) {
  scene::Case c = empty_case({});
  const Box box(c);
  Spheres all = random_spheres(box, 300, 0.01, 0.08, 3);
  for (std::size_t i = 0; i < 100; ++i) all.motion[3 * i].x = all.motion[0].x;  // ties
  std::vector<std::int32_t> some;
  for (std::int32_t i = 299; i >= 0; --i)
    if (i % 3 != 1) some.push_back(i);
  Spheres part = all;
  part.select(some);
  const auto ids = [&box](Spheres spheres) {
    order_by_place(box, spheres);
    spheres.select(order_of(spheres));
    return spheres.id;
  };
  std::vector<std::int32_t> expected = ids(all);
  std::erase_if(expected, [](std::int32_t id) { return id % 3 == 1; });
  EXPECT_EQ(ids(part), expected);
}

TEST(Skin, FollowsThePace) {
  Skin skin(0.005, 0.0);
  skin.adapt(0.0, 1000);
  const double at_rest = skin.width();
  skin.adapt(1e-3, 1000);
  const double slow = skin.width();
  skin.adapt(1e-3, 100);
  const double fast = skin.width();
  EXPECT_GT(at_rest, 0.0);
  EXPECT_GT(slow, at_rest);
  EXPECT_GT(fast, slow);
  EXPECT_LE(fast, 2.0 * 0.005);
  Skin fixed(0.005, 0.7);
  fixed.adapt(1e-3, 1);
  EXPECT_EQ(fixed.width(), 0.7 * 0.005);
}

TEST(NeighborList, SkinDoesNotChangeABit) {
  // A splash of spheres and clumps between walls; lists built at every step,
  // rarely or as the run asks for hold the same contacts in the same order.
  const auto run = [](double skin) {
    scene::Case c = empty_case({.mu_s = 0.5, .mu_r = 0.1});
    c.gravity_m_s2.z() = -9.81;
    c.lower_m.setConstant(-0.5);
    c.upper_m.setConstant(0.5);
    c.walls = scene::box_walls("bin", "wall", {-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, {"+z"});
    const std::vector<scene::SizeClass> sizes{{0.008, 0.012, 1.0}};
    scene::Layer layer{
        0.15,
        {{.material = "grain", .mass_fraction = 0.6, .sizes = sizes},
         {.material = "grain", .clump = "sinter_3", .mass_fraction = 0.4, .sizes = sizes}}};
    c.fill = scene::Fill{{-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, 0.25, {layer}};
    Simulation sim(c, {.skin_radii = skin});
    while (sim.time_s() < 0.15) sim.step(10);
    EXPECT_GT(sim.contacts(), 5u);
    EXPECT_GT(sim.steps(), 2500);  // the order has changed on the way
    return std::pair{sim.spheres(), sim.rebuilds()};
  };
  const auto often = run(0.02);
  const auto rarely = run(2.0);
  const auto tuned = run(0.0);
  EXPECT_GT(often.second, 5 * rarely.second);
  ASSERT_EQ(often.first.size(), rarely.first.size());
  for (std::size_t s = 0; s < often.first.size(); ++s)
    for (const auto& other : {rarely.first[s], tuned.first[s]}) {
      EXPECT_EQ(often.first[s].position, other.position);
      EXPECT_EQ(often.first[s].velocity, other.velocity);
      EXPECT_EQ(often.first[s].angular_velocity, other.angular_velocity);
    }
}

}  // namespace
}  // namespace repose::dem
