#include "wrong_case.hpp"

namespace repose::scene {
namespace {

const std::vector<Wrong> kWrongWalls = {
    {"wall twice", [](Case& c) { c.walls[1].name = "bin.-x"; }, "stands twice"},
    {"wall material", [](Case& c) { c.walls[0].material = "wood"; }, "\"wood\" is not known"},
    {"no normal", [](Case& c) { shape_of<Plane>(c, "ground").normal.setZero(); }, "normal is zero"},
    {"no edge", [](Case& c) { shape_of<Rectangle>(c, "bin.-x").edge_u.setZero(); }, "no length"},
    {"skew edges",
     [](Case& c) {
       shape_of<Rectangle>(c, "bin.-x").edge_u += 0.1 * shape_of<Rectangle>(c, "bin.-x").edge_v;
     },
     "perpendicular"},
    {"plane across the period",
     [](Case& c) {
       shape_of<Plane>(c, "ground").normal = {0, 1, 0};
     },
     "periodic"},
    {"short wall", [](Case& c) { shape_of<Rectangle>(c, "bin.-x").edge_u *= 0.5; },
     "spans the whole period"},
    {"disc radius", [](Case& c) { shape_of<Disc>(c, "lid").radius_m = 0.0; },
     "wall \"lid\": radius_m = 0"},
    {"disc normal", [](Case& c) { shape_of<Disc>(c, "lid").normal.setZero(); }, "normal is zero"},
    {"ring", [](Case& c) { shape_of<Disc>(c, "lid").inner_radius_m = 0.04; },
     "inner_radius_m = 0.04: must be below radius_m"},
    {"cylinder axis",
     [](Case& c) { shape_of<Cone>(c, "drum").end = shape_of<Cone>(c, "drum").start; },
     "axis needs a length"},
    {"cone radius", [](Case& c) { shape_of<Cone>(c, "funnel").end_radius_m = kNan; },
     "end_radius_m"},
    {"cone without radius",
     [](Case& c) {
       auto& cone = shape_of<Cone>(c, "funnel");
       cone.start_radius_m = cone.end_radius_m = 0.0;
     },
     "0 at both ends"},
    {"mesh file", [](Case& c) { shape_of<Mesh>(c, "blade").file = ""; }, "name an STL file"},
    {"mesh scale", [](Case& c) { shape_of<Mesh>(c, "blade").scale = 0.0; }, "scale = 0"},
    {"mesh angle", [](Case& c) { shape_of<Mesh>(c, "blade").smooth_deg = 90.0; },
     "smooth_deg = 90"},
    {"disc out of the period", [](Case& c) { shape_of<Disc>(c, "lid").centre.y() = 0.02; },
     "reaches from -0.02"},
    {"funnel out of the period", [](Case& c) { shape_of<Cone>(c, "funnel").end_radius_m = 0.06; },
     "lie within the period"},
    {"cylinder shorter on one side",
     [](Case& c) {
       shape_of<Cone>(c, "drum").start.y() = -0.05;
       shape_of<Cone>(c, "drum").end.y() = 0.05;
     },
     "must span the period"},
};

TEST(Validate, NamesWhatIsWrongWithWalls) {
  expect_each_is_refused(kWrongWalls);
}

const std::vector<Wrong> kWrongMotions = {
    {"no walls", [](Case& c) { c.motions[0].walls.clear(); }, "motion 1: names no walls"},
    {"unknown wall", [](Case& c) { c.motions[0].walls = {"door"}; }, "\"door\" is not a wall"},
    {"wall twice",
     [](Case& c) {
       c.motions[0].walls = {"drum", "drum"};
     },
     "names the wall \"drum\" twice"},
    {"unknown stage", [](Case& c) { c.motions[0].stage = "pour"; },
     "stage = \"pour\" is not a stage; the case has fill and open"},
    {"opened before", [](Case& c) { c.stages[0].opens = {"drum"}; },
     "which stage \"fill\" has taken away before"},
    {"opened with the stage", [](Case& c) { c.stages[1].opens = {"drum"}; },
     "has taken away before"},
    {"axis", [](Case& c) { std::get<Rotation>(c.motions[0].path).axis.setZero(); }, "axis is zero"},
    {"rate", [](Case& c) { std::get<Rotation>(c.motions[0].path).rate_rad_s = kNan; },
     "rate_rad_s"},
    {"velocity", [](Case& c) { std::get<Translation>(c.motions[1].path).velocity_m_s.x() = kNan; },
     "velocity_m_s.x"},
    {"frequency", [](Case& c) { std::get<Oscillation>(c.motions[2].path).frequency_hz = 0.0; },
     "frequency_hz = 0"},
    {"phase", [](Case& c) { std::get<Oscillation>(c.motions[2].path).phase_rad = kNan; },
     "phase_rad"},
    {"no points", [](Case& c) { c.motions[3].path = TimeTable{}; }, "has no points"},
    {"points that differ",
     [](Case& c) { std::get<TimeTable>(c.motions[3].path).times_s.pop_back(); },
     "2 times stand beside 3"},
    {"points out of order",
     [](Case& c) { std::get<TimeTable>(c.motions[3].path).times_s[2] = 0.1; }, "times must ascend"},
    {"a table that starts elsewhere",
     [](Case& c) {
       c.motions[3].start_s = 0.2;
       std::get<TimeTable>(c.motions[3].path).displacements_m[0].z() = 0.05;
     },
     "motion 4: the first displacement_m.z = 0.05: the wall would jump"},
    {"a table that starts elsewhere with its stage",
     [](Case& c) {
       c.motions[3].stage = "fill";
       std::get<TimeTable>(c.motions[3].path).displacements_m[0].x() = -0.05;
     },
     "the first displacement_m.x = -0.05: the wall would jump"},
    {"tilted plane", [](Case& c) { c.motions[0].walls = {"ground"}; }, "only about its normal"},
    {"along the period",
     [](Case& c) { std::get<Translation>(c.motions[1].path).velocity_m_s.y() = 0.1; },
     "along the periodic direction y"},
    {"shaken along the period",
     [](Case& c) {
       c.motions[2].walls = {"lid"};
       std::get<Oscillation>(c.motions[2].path).amplitude_m.y() = 0.1;
     },
     "along the periodic direction y"},
    {"table along the period",
     [](Case& c) { std::get<TimeTable>(c.motions[3].path).displacements_m[1].y() = 0.1; },
     "along the periodic direction y"},
    {"turned out of the period",
     [](Case& c) {
       std::get<Rotation>(c.motions[0].path).axis = {1, 0, 0};
     },
     "along the periodic direction y"},
    {"start", [](Case& c) { c.motions[0].start_s = -0.1; }, "start_s = -0.1"},
    {"end", [](Case& c) { c.motions[0].end_s = 0.1; }, "must be above start_s"},
    {"never", [](Case& c) { c.motions[0].start_s = 2.0; },
     "never comes: the stages that follow last 2 s"},
};

TEST(Validate, NamesWhatIsWrongWithMotions) {
  expect_each_is_refused(kWrongMotions);
}

TEST(Validate, TakesATableThatHoldsAWallElsewhereFromTheBeginning) {
  Case c = sample_case();
  std::get<TimeTable>(c.motions[3].path).displacements_m[0].z() = 0.05;
  EXPECT_NO_THROW(validate(c));
}

}  // namespace
}  // namespace repose::scene
