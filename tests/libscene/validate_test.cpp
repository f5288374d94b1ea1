#include <gtest/gtest.h>

#include <functional>

#include "repose/base/error.hpp"
#include "sample_case.hpp"

namespace repose::scene {
namespace {

TEST(Validate, AcceptsTheSample) {
  EXPECT_NO_THROW(validate(sample_case()));
}

/// One change that makes the sample wrong, and words that the message must have.
struct Wrong {
  const char* what;
  std::function<void(Case&)> change;
  const char* words;
};

Plane& plane_of(Case& c) {
  return std::get<Plane>(c.walls.back().shape);
}
Rectangle& face_of(Case& c) {
  return std::get<Rectangle>(c.walls[0].shape);
}
std::vector<SizeClass>& sizes_of(Case& c, std::size_t layer) {
  return std::get<std::vector<SizeClass>>(c.fill->layers[layer].mixture[0].sizes);
}

const double kNan = std::numeric_limits<double>::quiet_NaN();

const std::vector<Wrong> kWrong = {
    {"large time step", [](Case& c) { c.time_step_rayleigh_fraction = 0.51; }, "at most 0.5"},
    {"no time step", [](Case& c) { c.time_step_rayleigh_fraction = 0.0; }, "above 0"},
    {"large seed", [](Case& c) { c.seed = 1ULL << 63; }, "below 2^63"},
    {"gravity", [](Case& c) { c.gravity_m_s2.x() = kNan; }, "gravity_m_s2.x"},
    {"empty domain", [](Case& c) { c.upper_m.z() = -0.3; }, "domain.upper_m.z"},
    {"series", [](Case& c) { c.output.series_interval_s = 0.0; }, "series_interval_s"},
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
    {"wall twice", [](Case& c) { c.walls[1].name = "bin.-x"; }, "stands twice"},
    {"wall material", [](Case& c) { c.walls[0].material = "wood"; }, "\"wood\" is not known"},
    {"no normal", [](Case& c) { plane_of(c).normal.setZero(); }, "normal is zero"},
    {"no edge", [](Case& c) { face_of(c).edge_u.setZero(); }, "no length"},
    {"skew edges", [](Case& c) { face_of(c).edge_u += 0.1 * face_of(c).edge_v; }, "perpendicular"},
    {"plane across the period",
     [](Case& c) {
       plane_of(c).normal = {0, 1, 0};
     },
     "periodic"},
    {"short wall", [](Case& c) { face_of(c).edge_u *= 0.5; }, "spans the whole period"},
    {"region", [](Case& c) { c.regions[1].upper.x() = -2; }, "region \"all\""},
    {"fill upside down", [](Case& c) { c.fill->upper.z() = -0.1; }, "fill.upper_m.z"},
    {"fill outside", [](Case& c) { c.fill->upper.x() = 0.31; }, "out of the domain"},
    {"too dense", [](Case& c) { c.fill->solid_fraction = 0.5; }, "at most 0.36"},
    {"no layers", [](Case& c) { c.fill->layers.clear(); }, "no layers"},
    {"layer mass", [](Case& c) { c.fill->layers[0].mass_kg = 0.0; }, "mass_kg = 0"},
    {"layer material", [](Case& c) { c.fill->layers[0].mixture[0].material = "coal"; },
     "not known"},
    {"no sizes", [](Case& c) { sizes_of(c, 0).clear(); }, "no sizes"},
    {"fractions", [](Case& c) { sizes_of(c, 0)[0].mass_fraction = 0.3; }, "must be 1"},
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
       c.particles.clear();
     },
     "no particles"},
    {"no stage", [](Case& c) { c.stages.clear(); }, "no stage"},
    {"stage time", [](Case& c) { c.stages[0].duration_s = 0.0; }, "duration_s = 0"},
    {"stage minimum", [](Case& c) { c.stages[0].minimum_s = 9.0; }, "at most duration_s"},
    {"opens nothing", [](Case& c) { c.stages[1].opens = {"gate"}; }, "\"gate\" is not a wall"},
    {"opens twice", [](Case& c) { c.stages[0].opens = {"bin"}; }, "taken away before"},
    {"rest without weight", [](Case& c) { c.gravity_m_s2.setZero(); }, "gravity_m_s2 is zero"},
    {"flow of nothing", [](Case& c) { c.stages[1].flow_ends->region = "x"; }, "not a region"},
    {"flow window", [](Case& c) { c.stages[1].flow_ends->window_s = 0.0; }, "window_s"},
};

TEST(Validate, NamesWhatIsWrong) {
  for (const Wrong& wrong : kWrong) {
    Case c = sample_case();
    wrong.change(c);
    try {
      validate(c);
      ADD_FAILURE() << wrong.what << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(wrong.words), std::string::npos)
          << wrong.what << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace repose::scene
