// What many processes would have to send and to compute, counted without owning them: a settled
// bed, tiled to so many spheres a rank, is cut and the ghosts of each rank are counted.
// repose_dry_decomposition CASE.toml SPHERES_PER_RANK RANKS...
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <utility>
#include <vector>

#include "neighbor/neighbor_lists.hpp"
#include "neighbor/sphere_order.hpp"
#include "parallel/domain.hpp"
#include "repose/scene/case.hpp"

namespace {

using namespace repose::dem;

struct Bed {
  Spheres spheres;
  std::vector<std::int64_t> costs;
  std::vector<std::pair<std::size_t, std::size_t>> contacts;  ///< of spheres
  Vec3 lower, upper;                                          ///< of what is repeated
};

/// The spheres of the case with what each costs in a step.
Bed bed_of(const repose::scene::Case& scene, double skin) {
  Bed bed;
  for (const auto& table : scene.particle_tables)
    for (const auto& particle : repose::scene::load_particles(scene, table)) {
      const auto id = static_cast<std::int32_t>(bed.spheres.size());
      bed.spheres.add({.motion = {particle.position, particle.radius_m, Vec3::Zero(), 1.0},
                       .id = id,
                       .body = id,
                       .mass = 1.0});
    }
  const Box box(scene);
  const Walls walls(scene);
  Clumps clumps;
  NeighborLists lists;
  ContactPool pool;
  WallContacts wall_contacts;
  order_by_place(box, bed.spheres);
  rebuild(box, skin, walls, sort_spheres(bed.spheres, clumps, wall_contacts), bed.spheres, lists,
          pool);
  for (Neighbor& neighbor : lists.pairs.entries) {
    const Motion& a = bed.spheres.motion[static_cast<std::size_t>(neighbor.row)];
    const Motion& b = bed.spheres.motion[static_cast<std::size_t>(neighbor.other)];
    if ((a.x - b.x).norm() >= a.radius + b.radius) continue;
    neighbor.contact = pool.begin_contact();
    bed.contacts.emplace_back(neighbor.row, neighbor.other);
  }
  for (const WeightedPoint& body :
       weighted_bodies({bed.spheres, clumps, lists, pool, wall_contacts}))
    bed.costs.push_back(body.cost);
  bed.lower = bed.upper = bed.spheres.motion[0].x;
  for (const Motion& sphere : bed.spheres.motion) {
    bed.lower = bed.lower.cwiseMin(sphere.x - Vec3::Constant(sphere.radius));
    bed.upper = bed.upper.cwiseMax(sphere.x + Vec3::Constant(sphere.radius));
  }
  return bed;
}

struct Spread {
  double mean, most;
};
template <class Values>
Spread spread_of(const Values& values) {
  Spread spread{0.0, 0.0};
  for (const auto value : values) {
    spread.mean += static_cast<double>(value) / static_cast<double>(values.size());
    spread.most = std::max(spread.most, static_cast<double>(value));
  }
  return spread;
}

void count(const Bed& bed, double skin, double spheres_per_rank, int ranks) {
  const double wanted = spheres_per_rank * ranks;
  const auto tiles = static_cast<int>(std::ceil(wanted / static_cast<double>(bed.spheres.size())));
  // Repeated along the side that is shortest so far.
  int along[3] = {1, 1, 1};
  const Vec3 side = bed.upper - bed.lower;
  while (along[0] * along[1] * along[2] < tiles) {
    int least = 0;
    for (int k = 1; k < 3; ++k)
      if (along[k] * side[k] < along[least] * side[least]) least = k;
    ++along[least];
  }
  repose::scene::Case scene;
  scene.lower_m = bed.lower;
  scene.upper_m = bed.lower;
  for (int k = 0; k < 3; ++k) scene.upper_m[k] += along[k] * side[k] * (1.0 + 1e-12);
  const Box box(scene);
  std::vector<WeightedPoint> points;
  std::vector<double> radii;
  for (int z = 0; z < along[2]; ++z)
    for (int y = 0; y < along[1]; ++y)
      for (int x = 0; x < along[0]; ++x)
        for (std::size_t i = 0; i < bed.spheres.size(); ++i) {
          points.push_back(
              {bed.spheres.motion[i].x + Vec3(x, y, z).cwiseProduct(side), bed.costs[i]});
          radii.push_back(bed.spheres.motion[i].radius);
        }
  const auto begin = std::chrono::steady_clock::now();
  const Decomposition cut(box, points, ranks, Communicator());
  const std::chrono::duration<double> span = std::chrono::steady_clock::now() - begin;

  const double largest = *std::max_element(radii.begin(), radii.end());
  std::vector<std::int64_t> owned(static_cast<std::size_t>(ranks), 0), ghosts(owned), cost(owned);
  std::vector<int> owner_of;
  std::vector<std::set<int>> neighbors(owned.size());
  std::vector<int> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int owner = cut.owner_of(points[i].x);
    owner_of.push_back(owner);
    ++owned[static_cast<std::size_t>(owner)];
    cost[static_cast<std::size_t>(owner)] += points[i].cost;
    near.clear();
    cut.add_ranks_within(points[i].x, radii[i] + largest + skin, near);
    for (const int rank : near)
      if (rank != owner) {
        ++ghosts[static_cast<std::size_t>(rank)];
        neighbors[static_cast<std::size_t>(rank)].insert(owner);
      }
  }
  double shared = 0.0;
  for (std::size_t tile = 0; tile < points.size(); tile += bed.spheres.size())
    for (const auto& [i, j] : bed.contacts)
      shared += owner_of[tile + i] != owner_of[tile + j] ? 1.0 : 0.0;
  const double contacts =
      static_cast<double>(bed.contacts.size() * (points.size() / bed.spheres.size()));
  std::vector<std::size_t> messages;
  for (const std::set<int>& of_rank : neighbors) messages.push_back(of_rank.size());
  const Spread o = spread_of(owned), g = spread_of(ghosts), c = spread_of(cost),
               m = spread_of(messages);
  std::printf(
      "ranks=%d spheres=%zu spheres_per_rank=%.0f most_spheres=%.0f cost_imbalance=%.4f "
      "ghosts_per_rank=%.0f most_ghosts=%.0f bytes_per_step_and_rank=%.0f most_bytes=%.0f "
      "neighbors=%.1f most_neighbors=%.0f contacts_computed_twice=%.4f cut_s=%.2f\n",
      ranks, points.size(), o.mean, o.most, c.most / c.mean, g.mean, g.most, 72.0 * g.mean,
      72.0 * g.most, m.mean, m.most, shared / contacts, span.count());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "repose_dry_decomposition CASE.toml SPHERES_PER_RANK RANKS...\n");
    return 2;
  }
  try {
    constexpr double kSkin = 0.0004;  // a tenth of the smallest radius, as at rest
    const Bed bed = bed_of(repose::scene::read_case(argv[1]), kSkin);
    for (int k = 3; k < argc; ++k) count(bed, kSkin, std::atof(argv[2]), std::atoi(argv[k]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
