// What decides the first stages of a run and what does not.
#include <gtest/gtest.h>

#include <functional>

#include "repose/scene/case.hpp"

namespace repose::scene {
namespace {

/// A box is filled, then lifted while a plate turns.
Case lifted() {
  Case c;
  c.materials = {{"grain", 2500, 1e7, 0.25}};
  c.pairs = {{.first = "grain", .second = "grain", .mu_s = 0.5, .cohesion_energy_density_j_m3 = 7}};
  c.motions = {{.walls = {"box"}, .path = Translation{{0, 0, 0.1}}, .stage = "lift"},
               {.walls = {"plate"}, .path = Rotation{{0, 0, 1}, {0, 1, 0}, 3.0}, .stage = "lift"},
               {.walls = {"floor"}, .path = Oscillation{{0, 0, 1e-3}, 50.0, 0.0}}};
  c.stages = {{.name = "fill", .duration_s = 0.5},
              {.name = "lift", .opens = {"lid"}, .duration_s = 2.0},
              {.name = "rest", .duration_s = 1.0}};
  return c;
}

Case changed(const std::function<void(Case&)>& change) {
  Case c = lifted();
  change(c);
  return c;
}

TEST(BeginningOf, IsEqualWhereOnlyLaterStagesDiffer) {
  const std::function<void(Case&)> kLater[] = {
      [](Case& c) { c.stages[1].duration_s = 3.0; },
      [](Case& c) { c.stages[1].opens.clear(); },
      [](Case& c) { c.stages.pop_back(); },
      [](Case& c) { c.parameters["lift_m_s"] = 0.2; },
      [](Case& c) { std::get<Translation>(c.motions[0].path).velocity_m_s.z() = 0.2; },
      [](Case& c) { std::get<Rotation>(c.motions[1].path).rate_rad_s = -1.0; },
      [](Case& c) { c.motions[1].start_s = 0.3; }};
  for (const auto& change : kLater) {
    EXPECT_TRUE(beginning_of(changed(change), 1) == beginning_of(lifted(), 1));
    EXPECT_FALSE(changed(change) == lifted());
  }
}

TEST(BeginningOf, DiffersByWhatMayMatterBefore) {
  const std::function<void(Case&)> kEarlier[] = {
      [](Case& c) { c.seed = 2; },
      [](Case& c) { c.pairs[0].mu_s = 0.6; },
      [](Case& c) { c.stages[0].duration_s = 0.6; },
      [](Case& c) { std::get<Oscillation>(c.motions[2].path).frequency_hz = 20; },
      [](Case& c) { std::get<Rotation>(c.motions[1].path).centre.z() = 0; },  // torques about it
      [](Case& c) { c.motions[0].walls = {"plate"}; },
      [](Case& c) { c.output.series_interval_s = 0.1; }};
  for (const auto& change : kEarlier)
    EXPECT_FALSE(beginning_of(changed(change), 1) == beginning_of(lifted(), 1));
  const auto longer_lift = changed([](Case& c) { c.stages[1].duration_s = 3.0; });
  EXPECT_FALSE(beginning_of(longer_lift, 2) == beginning_of(lifted(), 2));
}

TEST(BeginningOf, IsFreeOfCoefficientsThatNoStageUsed) {
  const auto filled_alike = [](double mu_s, double cohesion) {
    return changed([&](Case& c) {
      c.stages[0].coefficients = StageCoefficients{.mu_s = 0.3};
      c.pairs[0].mu_s = mu_s;
      c.pairs[0].cohesion_energy_density_j_m3 = cohesion;
    });
  };
  EXPECT_TRUE(beginning_of(filled_alike(0.1, 7), 1) == beginning_of(filled_alike(0.9, 7), 1));
  EXPECT_FALSE(beginning_of(filled_alike(0.1, 7), 2) == beginning_of(filled_alike(0.9, 7), 2));
  EXPECT_FALSE(beginning_of(filled_alike(0.1, 7), 1) == beginning_of(filled_alike(0.1, 8), 1));
}

TEST(BeginningOf, NoStageIsWhatIsThereAtTheStart) {
  EXPECT_TRUE(beginning_of(lifted(), 0).stages.empty());
  EXPECT_TRUE(beginning_of(lifted(), 99) == lifted());
}

}  // namespace
}  // namespace repose::scene
