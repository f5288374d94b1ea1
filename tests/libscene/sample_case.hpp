// A case with every kind of entry, as a base for tests that change one thing.
#pragma once

#include <limits>

#include "repose/scene/case.hpp"

namespace repose::scene {

/// One wall of each further shape, the period along y.
inline void add_shapes(Case& c) {
  c.walls.push_back({"lid", "steel", Disc{{0, 0.05, 0.6}, {0, 0, 3}, 0.04, 0.01}});
  c.walls.push_back({"drum", "steel", Cone{{0.25, 0, 0.6}, {0.25, 0.1, 0.6}, 0.03, 0.03}});
  c.walls.push_back({"funnel", "steel", Cone{{-0.2, 0.05, 0.55}, {-0.2, 0.05, 0.6}, 0.01, 0.04}});
  c.walls.push_back({"blade", "steel",
                     Mesh{.file = "/parts/blade.stl",
                          .scale = 0.001,
                          .translation = {0.1, 0.05, 1.0 / 3.0},
                          .open = true,
                          .drop_degenerate = true,
                          .smooth_deg = 20.0,
                          .content_hash = 0xf00dcafef00dcafeULL}});
}

/// One motion of each kind.
inline std::vector<Motion> sample_motions() {
  Motion turn{.walls = {"drum"}, .path = Rotation{{0.25, 0, 0.6}, {0, 2, 0}, -0.1}};
  turn.stage = "open";
  turn.start_s = 0.1;
  Motion lift{.walls = {"lid", "funnel"}, .path = Translation{{0, 0, 0.01}}};
  lift.end_s = 0.7;
  Motion shake{.walls = {"ground"}, .path = Oscillation{{0.001, 0, 0}, 50.0, 0.25}};
  Motion cut{.walls = {"blade"},
             .path = TimeTable{{0.0, 0.1, 0.3}, {{0, 0, 0}, {0, 0, -0.0}, {0.02, 0, 0.1}}}};
  return {turn, lift, shake, cut};
}

/// Spheres and clumps, each of a continuous distribution.
inline std::vector<Grains> sample_mixture() {
  return {
      {.material = "pellet", .mass_fraction = 0.25, .sizes = LogNormal{0.012, 1.2, 0.009, 0.0151}},
      {.material = "pellet",
       .clump = "sinter_3",
       .mass_fraction = 0.75,
       .sizes = RosinRammler{0.012, 3.3, 0.009, 0.015}}};
}

inline Case sample_case() {
  const double inf = std::numeric_limits<double>::infinity();
  Case c;
  c.seed = 42;
  c.time_step_rayleigh_fraction = 0.2;
  c.gravity_m_s2 = {0.1, -0.0, -9.81};
  c.lower_m = {-0.3, 0.0, -0.3};
  c.upper_m = {0.3, 0.1, 0.7};
  c.periodic.y = true;
  c.materials = {{"pellet", 3602.0, 5e6, 0.25}, {"steel", 7850.0, 5e8, 0.3}};
  c.contact = {.tail = Tail::clip,
               .rolling = RollingModel::a,
               .rolling_stiffness = RollingStiffness::kt,
               .compatibility = Compatibility::liggghts};
  c.clumps = {{"dimer", {{{0, 0, 0}, 1.0}, {{1.0 / 3.0, 0, 0}, 0.9}}}};
  c.pairs = {{"pellet", "pellet", 0.7, 0.5, 0.1, 0.3, 1e5},
             {"steel", "pellet", 0.4, 1.0 / 3.0, 0.0}};
  Wall plane;
  plane.name = "ground";
  plane.material = "steel";
  plane.shape = Plane{.origin = {0.0, 0.0, -0.25}, .normal = {0.0, 0.0, 2.0}};
  c.walls = box_walls("bin", "steel", {-0.2, 0.0, 0.0}, {0.2, 0.1, 0.5}, {"+z", "-y", "+y"});
  add_shapes(c);
  c.walls.push_back(plane);
  c.regions = {{"bin", {-0.2, -inf, 0.0}, {0.2, inf, inf}},
               {"all", {-1, -1, -1}, {1, 1, 1}},
               {"sink",
                {-inf, -inf, -inf},
                {inf, inf, inf},
                RegionCylinder{{0, 0, -0.3}, {0, 0, -0.2}, 0.05},
                true}};
  Fill fill;
  fill.lower = {-0.2, 0.0, 0.0};
  fill.upper = {0.2, 0.1, 0.5};
  const std::vector<SizeClass> two{{0.010, 0.010, 0.25}, {0.011, 0.016, 0.75}};
  const std::vector<SizeClass> one{{0.012, 0.012, 1.0}};
  fill.layers = {{1.0, {{.material = "pellet", .sizes = two}}},
                 {0.5, {{.material = "pellet", .sizes = one}}},
                 {0.2, sample_mixture()}};
  c.fill = fill;
  c.rains = {{.name = "shower",
              .mixture = {{.material = "pellet", .clump = "dimer", .sizes = one}},
              .mass_kg = 0.1,
              .mass_rate_kg_s = 0.3,
              .lower = {-0.1, 0.0, 0.5},
              .upper = {0.1, 0.1, 0.6},
              .velocity = {0, 0, -1},
              .stage = "open",
              .start_s = 0.1}};
  c.particle_tables = {{.location = "/data/bed.h5:/snapshots/000002",
                        .material = "pellet",
                        .clump = "",
                        .content_hash = 0x00ab54a98ceb1f0aULL}};
  c.particles = {{"pellet", {0.25, 0.05, -0.2}, {0, 0, 1e-300}, {1, 2, 3}, 0.1 / 7.0},
                 {.material = "pellet",
                  .position = {-0.25, 0.05, -0.2},
                  .radius_m = 0.005,
                  .clump = "sinter_3",
                  .orientation_wxyz = {0.5, 0.5, -0.5, 0.5}}};
  Stage first;
  first.name = "fill";
  first.duration_s = 0.5;
  first.minimum_s = 0.1;
  first.at_rest = AtRest{1e-5, 0.03};
  first.coefficients = StageCoefficients{.restitution = 0.4, .mu_s = 0.35, .mu_r = 0.05};
  Stage second;
  second.name = "open";
  second.opens = {"bin.-z"};
  second.duration_s = 2.0;
  second.flow_ends = FlowEnds{"bin", 0.01, 0.15};
  c.stages = {first, second};
  c.motions = sample_motions();
  c.output = {.snapshot_interval_s = 0.25,
              .series_interval_s = 0.01,
              .vtp = true,
              .energy = true,
              .checkpoint_wall_time_s = 60.0};
  c.parameters = {{"mu_s_pp", 0.1 / 3.0}, {"0 odd \"name\"", -1e-300}};
  return c;
}

}  // namespace repose::scene
