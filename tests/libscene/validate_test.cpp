#include "wrong_case.hpp"

namespace repose::scene {
namespace {

TEST(Validate, AcceptsTheSample) {
  EXPECT_NO_THROW(validate(sample_case()));
}

const std::vector<Wrong> kWrong = {
    {"large time step", [](Case& c) { c.time_step_rayleigh_fraction = 0.51; }, "at most 0.5"},
    {"no time step", [](Case& c) { c.time_step_rayleigh_fraction = 0.0; }, "above 0"},
    {"large seed", [](Case& c) { c.seed = 1ULL << 63; }, "below 2^63"},
    {"gravity", [](Case& c) { c.gravity_m_s2.x() = kNan; }, "gravity_m_s2.x"},
    {"empty domain", [](Case& c) { c.upper_m.z() = -0.3; }, "domain.upper_m.z"},
    {"series", [](Case& c) { c.output.series_interval_s = 0.0; }, "series_interval_s"},
    {"checkpoint", [](Case& c) { c.output.checkpoint_wall_time_s = -1.0; },
     "checkpoint_wall_time_s"},
    {"snapshots", [](Case& c) { c.output.snapshot_interval_s = -1.0; }, "snapshot_interval_s"},
    {"no material", [](Case& c) { c.materials.clear(); }, "no material"},
    {"same name", [](Case& c) { c.materials[1].name = "pellet"; }, "stands twice"},
    {"no name", [](Case& c) { c.materials[1].name = ""; }, "empty name"},
    {"density", [](Case& c) { c.materials[0].density_kg_m3 = 0.0; }, "density_kg_m3 = 0"},
    {"modulus", [](Case& c) { c.materials[0].youngs_modulus_pa = -1.0; }, "youngs_modulus_pa = -1"},
    {"Poisson", [](Case& c) { c.materials[0].poissons_ratio = 0.6; }, "(-1, 0.5]"},
    {"no pair", [](Case& c) { c.pairs.pop_back(); }, "\"pellet\", \"steel\"] is missing"},
    {"pair twice",
     [](Case& c) {
       c.pairs.push_back({"pellet", "steel"});
     },
     "stands twice"},
    {"pair of nothing", [](Case& c) { c.pairs[0].first = "coal"; }, "\"coal\" is not known"},
    {"restitution 0", [](Case& c) { c.pairs[0].restitution = 0.0; }, "must be in (0, 1]"},
    {"restitution", [](Case& c) { c.pairs[0].restitution = 1.1; }, "restitution = 1.1"},
    {"mu_s", [](Case& c) { c.pairs[0].mu_s = -0.1; }, "mu_s = -0.1"},
    {"mu_r", [](Case& c) { c.pairs[0].mu_r = kNan; }, "mu_r"},
    {"rolling damping", [](Case& c) { c.pairs[0].rolling_damping = -1.0; }, "rolling_damping"},
    {"region", [](Case& c) { c.regions[1].upper.x() = -2; }, "region \"all\""},
    {"no stage", [](Case& c) { c.stages.clear(); }, "no stage"},
    {"stage time", [](Case& c) { c.stages[0].duration_s = 0.0; }, "duration_s = 0"},
    {"stage minimum", [](Case& c) { c.stages[0].minimum_s = 9.0; }, "at most duration_s"},
    {"opens nothing", [](Case& c) { c.stages[1].opens = {"gate"}; }, "\"gate\" is not a wall"},
    {"opens twice", [](Case& c) { c.stages[0].opens = {"bin"}; }, "taken away before"},
    {"rest without weight", [](Case& c) { c.gravity_m_s2.setZero(); }, "gravity_m_s2 is zero"},
    {"flow of nothing", [](Case& c) { c.stages[1].flow_ends->region = "x"; }, "not a region"},
    {"stage restitution", [](Case& c) { c.stages[0].coefficients->restitution = 0.0; },
     "stage \"fill\": coefficients.restitution = 0"},
    {"stage friction", [](Case& c) { c.stages[0].coefficients->mu_r = -1.0; },
     "coefficients.mu_r = -1"},
    {"flow window", [](Case& c) { c.stages[1].flow_ends->window_s = 0.0; }, "window_s"},
    {"name with a slash", [](Case& c) { c.materials[1].name = "a/b"; }, "must not have a \"/\""},
    {"cohesion", [](Case& c) { c.pairs[0].cohesion_energy_density_j_m3 = -1.0; },
     "cohesion_energy_density_j_m3 = -1"},
    {"pairs of one column",
     [](Case& c) {
       c.materials = {{"a", 1, 1}, {"a_a", 1, 1}, {"b", 1, 1}, {"a_b", 1, 1}};
       c.pairs = {{"a", "a_b"}, {"a_a", "b"}};
     },
     "another pair has the same columns"},
    {"regions of one column",
     [](Case& c) {
       c.regions.push_back({"bin_pellet", {-1, -1, -1}, {1, 1, 1}});
     },
     "mass_bin_pellet_kg"},
    {"region radius", [](Case& c) { c.regions[2].cylinder->radius_m = 0.0; },
     "region \"sink\": radius_m = 0"},
    {"region axis", [](Case& c) { c.regions[2].cylinder->end = c.regions[2].cylinder->start; },
     "same point"},
    {"flow into nothing", [](Case& c) { c.stages[1].flow_ends->region = "sink"; },
     "removes its particles"},
};

TEST(Validate, NamesWhatIsWrongWithMaterialsRegionsAndStages) {
  expect_each_is_refused(kWrong);
}

}  // namespace
}  // namespace repose::scene
