#include "wrong_case.hpp"

namespace repose::scene {
namespace {

std::vector<SizeClass>& sizes_of(Case& c, std::size_t layer) {
  return std::get<std::vector<SizeClass>>(c.fill->layers[layer].mixture[0].sizes);
}

const std::vector<Wrong> kWrongGrains = {
    {"clump of nothing", [](Case& c) { c.clumps[0].spheres.clear(); }, "clump \"dimer\""},
    {"clump radius", [](Case& c) { c.clumps[0].spheres[0].radius = 0.0; }, "clump \"dimer\""},
    {"clump in two parts", [](Case& c) { c.clumps[0].spheres[1].position.x() = 3.0; },
     "clump \"dimer\""},
    {"shipped name", [](Case& c) { c.clumps[0].name = "sinter_3"; }, "stands twice"},
    {"mixture", [](Case& c) { c.fill->layers[2].mixture[0].mass_fraction = 0.3; },
     "sum of mass_fraction of the mixture = 1.05"},
    {"kind of negative mass", [](Case& c) { c.fill->layers[2].mixture[0].mass_fraction = -0.1; },
     "mass_fraction of pellet = -0.1"},
    {"one size as log-normal",
     [](Case& c) { std::get<LogNormal>(c.fill->layers[2].mixture[0].sizes).geometric_sd = 1.0; },
     "geometric_sd = 1: must be above 1"},
    {"median",
     [](Case& c) {
       std::get<LogNormal>(c.fill->layers[2].mixture[0].sizes).median_diameter_m = 0.0;
     },
     "median_diameter_m = 0"},
    {"cut-offs",
     [](Case& c) {
       std::get<LogNormal>(c.fill->layers[2].mixture[0].sizes).lower_diameter_m = 0.02;
     },
     "must be above lower_diameter_m"},
    {"no mass between",
     [](Case& c) {
       std::get<LogNormal>(c.fill->layers[2].mixture[0].sizes).median_diameter_m = 0.1;
     },
     "move the cut-offs"},
    {"scale",
     [](Case& c) {
       std::get<RosinRammler>(c.fill->layers[2].mixture[1].sizes).scale_diameter_m = -1.0;
     },
     "scale_diameter_m = -1"},
    {"spread",
     [](Case& c) { std::get<RosinRammler>(c.fill->layers[2].mixture[1].sizes).spread = 0.0; },
     "spread = 0"},
    {"no coarse mass",
     [](Case& c) {
       std::get<RosinRammler>(c.fill->layers[2].mixture[1].sizes).scale_diameter_m = 0.001;
     },
     "move the cut-offs"},
};

TEST(Validate, NamesWhatIsWrongWithGrains) {
  expect_each_is_refused(kWrongGrains);
}

const std::vector<Wrong> kWrongInsertion = {
    {"fill upside down", [](Case& c) { c.fill->upper.z() = -0.1; }, "fill.upper_m.z"},
    {"fill outside", [](Case& c) { c.fill->upper.x() = 0.31; }, "out of the domain"},
    {"too dense", [](Case& c) { c.fill->solid_fraction = 0.5; }, "at most 0.36"},
    {"no layers", [](Case& c) { c.fill->layers.clear(); }, "no layers"},
    {"layer mass", [](Case& c) { c.fill->layers[0].mass_kg = 0.0; }, "mass_kg = 0"},
    {"layer material", [](Case& c) { c.fill->layers[0].mixture[0].material = "coal"; },
     "not known"},
    {"no sizes", [](Case& c) { sizes_of(c, 0).clear(); }, "no sizes"},
    {"fractions", [](Case& c) { sizes_of(c, 0)[0].mass_fraction = 0.3; },
     "the sizes must sum to 1"},
    {"sizes", [](Case& c) { sizes_of(c, 0)[1].upper_diameter_m = 0.01; }, "at least lower"},
    {"period",
     [](Case& c) {
       sizes_of(c, 1) = {{0.051, 0.051, 1.0}};
     },
     "two of the largest"},
    {"wide sphere",
     [](Case& c) {
       c.fill->lower.x() = -0.01;
       c.fill->upper.x() = 0.005;
     },
     "m wide along x"},
    {"high column", [](Case& c) { c.fill->layers[0].mass_kg = 100.0; }, "raise fill.upper_m.z"},
    {"particle place", [](Case& c) { c.particles[0].position.x() = 1.0; }, "outside the domain"},
    {"particle radius", [](Case& c) { c.particles[0].radius_m = 0.0; }, "radius_m = 0"},
    {"particle period", [](Case& c) { c.particles[0].radius_m = 0.03; }, "two of the largest"},
    {"no particles",
     [](Case& c) {
       c.fill.reset();
       c.rains.clear();
       c.particle_tables.clear();
       c.particles.clear();
     },
     "no particles"},
    {"rain mass", [](Case& c) { c.rains[0].mass_kg = 0.0; }, "rain \"shower\": mass_kg = 0"},
    {"rain rate", [](Case& c) { c.rains[0].mass_rate_kg_s = -1.0; }, "mass_rate_kg_s = -1"},
    {"rain too slow", [](Case& c) { c.rains[0].mass_rate_kg_s = 0.05; },
     "takes 2 s, but the stages leave 1.9 s"},
    {"rain stage", [](Case& c) { c.rains[0].stage = "pour"; }, "is not a stage"},
    {"rain outside", [](Case& c) { c.rains[0].upper.z() = 0.8; }, "out of the domain"},
    {"rain box", [](Case& c) { c.rains[0].upper.z() = 0.505; }, "its box is only"},
    {"rain kind", [](Case& c) { c.rains[0].mixture[0].clump = "trimer"; }, "\"trimer\""},
    {"rain of nothing", [](Case& c) { c.rains[0].mixture.clear(); }, "has no particles"},
    {"rain twice", [](Case& c) { c.rains.push_back(c.rains[0]); }, "rain \"shower\" stands twice"},
    {"table place", [](Case& c) { c.particle_tables[0].location = ""; }, "particle_table"},
    {"table material", [](Case& c) { c.particle_tables[0].material = "coal"; }, "not known"},
    {"table clump", [](Case& c) { c.particle_tables[0].clump = "coal"; }, "particle_table"},
    {"particle clump", [](Case& c) { c.particles[1].clump = "coal"; }, "particle 2: "},
    {"orientation", [](Case& c) { c.particles[1].orientation_wxyz[0] = 1.0; }, "unit quaternion"},
    {"wide clump in the column",
     [](Case& c) {
       c.fill->lower.x() = 0.0;
       c.fill->upper.x() = 0.0155;
     },
     "m wide along x"},
    {"cylinder around the fill",
     [](Case& c) {
       wall_of(c, "funnel").shape = Cone{{0, 0.05, 0.2}, {0, 0.05, 0.3}, 0.007, 0.007};
     },
     "wall \"funnel\" around the fill is 0.014 m wide"},
    {"pair of rain",
     [](Case& c) {
       c.materials.push_back({"coal", 1400, 1e7});
       c.rains[0].mixture[0].material = "coal";
     },
     "is missing"},
};

TEST(Validate, NamesWhatIsWrongWithInsertion) {
  expect_each_is_refused(kWrongInsertion);
}

}  // namespace
}  // namespace repose::scene
