// A case with every kind of entry, as a base for tests that change one thing.
#pragma once

#include <limits>

#include "repose/scene/case.hpp"

namespace repose::scene {

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
  c.pairs = {{"pellet", "pellet", 0.7, 0.5, 0.1, 0.3}, {"steel", "pellet", 0.4, 1.0 / 3.0, 0.0}};
  Wall plane;
  plane.name = "ground";
  plane.material = "steel";
  plane.shape = Plane{.origin = {0.0, 0.0, -0.25}, .normal = {0.0, 0.0, 2.0}};
  c.walls = box_walls("bin", "steel", {-0.2, 0.0, 0.0}, {0.2, 0.1, 0.5}, {"+z", "-y", "+y"});
  c.walls.push_back(plane);
  c.regions = {{"bin", {-0.2, -inf, 0.0}, {0.2, inf, inf}}, {"all", {-1, -1, -1}, {1, 1, 1}}};
  Fill fill;
  fill.lower = {-0.2, 0.0, 0.0};
  fill.upper = {0.2, 0.1, 0.5};
  const std::vector<SizeClass> two{{0.010, 0.010, 0.25}, {0.011, 0.016, 0.75}};
  const std::vector<SizeClass> one{{0.012, 0.012, 1.0}};
  fill.layers = {{1.0, {{.material = "pellet", .sizes = two}}},
                 {0.5, {{.material = "pellet", .sizes = one}}}};
  c.fill = fill;
  c.particles = {{"pellet", {0.25, 0.05, -0.2}, {0, 0, 1e-300}, {1, 2, 3}, 0.1 / 7.0}};
  Stage first;
  first.name = "fill";
  first.duration_s = 0.5;
  first.minimum_s = 0.1;
  first.at_rest = AtRest{1e-5, 0.03};
  Stage second;
  second.name = "open";
  second.opens = {"bin.-z"};
  second.duration_s = 2.0;
  second.flow_ends = FlowEnds{"bin", 0.01, 0.15};
  c.stages = {first, second};
  c.output = {0.25, 0.01};
  return c;
}

}  // namespace repose::scene
