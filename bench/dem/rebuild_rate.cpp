// What building the neighbor lists costs: repose_rebuild_rate CASE.toml, by themselves and with one
// sphere among the others that is ten times as large as the smallest.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "neighbor/neighbor_lists.hpp"
#include "neighbor/sphere_order.hpp"

namespace {

using repose::dem::Vec3;

/// The spheres of the case; those that the large one would touch are left out.
repose::dem::Spheres spheres_of(const repose::scene::Case& scene, double large,
                                const Vec3& centre) {
  repose::dem::Spheres spheres;
  const auto add = [&spheres](const Vec3& x, double radius) {
    const auto id = static_cast<std::int32_t>(spheres.size());
    spheres.add({.motion = {x, radius, Vec3::Zero(), 1.0}, .id = id, .body = id, .mass = 1.0});
  };
  for (const auto& table : scene.particle_tables)
    for (const auto& particle : repose::scene::load_particles(scene, table))
      if (large == 0.0 || (particle.position - centre).norm() > large + particle.radius_m)
        add(particle.position, particle.radius_m);
  if (large > 0.0) add(centre, large);
  return spheres;
}

/// Seconds a sphere, the median of builds in the order that the spheres have.
double build_s(const repose::scene::Case& scene, double skin, repose::dem::Spheres spheres) {
  const repose::dem::Box box(scene);
  const repose::dem::Walls walls(scene);
  repose::dem::Clumps clumps;
  repose::dem::WallContacts contacts;
  repose::dem::order_by_place(box, spheres);
  repose::dem::sort_spheres(spheres, clumps, contacts);
  repose::dem::NeighborLists lists;
  repose::dem::ContactPool pool;
  std::vector<double> seconds;
  for (int k = 0; k < 16; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    repose::dem::rebuild(box, skin, walls, {}, spheres, lists, pool);
    const std::chrono::duration<double> span = std::chrono::steady_clock::now() - begin;
    if (k > 0) seconds.push_back(span.count() / static_cast<double>(spheres.size()));
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "repose_rebuild_rate CASE.toml\n");
    return 2;
  }
  try {
    const repose::scene::Case scene = repose::scene::read_case(argv[1]);
    const Vec3 centre(0.125, 0.125, 0.15);
    const double skin = 0.001;
    const double alike = build_s(scene, skin, spheres_of(scene, 0.0, centre));
    const double mixed = build_s(scene, skin, spheres_of(scene, 0.04, centre));
    std::printf("rebuild ns_per_sphere=%.1f with_large_sphere=%.1f ratio=%.3f\n", 1e9 * alike,
                1e9 * mixed, mixed / alike);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
