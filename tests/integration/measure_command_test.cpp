// `repose measure` as a user meets it: photographs and runs, and what bad input gets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "../dem_adapter/drawn_picture.hpp"
#include "program.hpp"
#include "repose/dem_adapter/drawdown.hpp"
#include "repose/scene/run_output.hpp"
#include "repose/table/io.hpp"

namespace repose {
namespace {

using test::Workbench;

void draw_cone(const Workbench& bench, const std::string& name, double angle_deg) {
  const test::Cone cone{300.0, 70.0, 290.0, angle_deg, angle_deg};
  const auto picture = test::drawn(
      600, 300, {30, 60, 120},
      [](double, double) {
        return dem_adapter::Rgb{200, 170, 120};
      },
      [&](double x, double y) { return cone.has(x, y); });
  test::write_bytes(bench / name, name.ends_with(".jpg") ? test::jpeg_of(picture, 92)
                                                         : dem_adapter::png_of(picture));
}

/// A finished run of a cone of spheres of 10 mm on z = 0.
void write_heap_run(const std::filesystem::path& folder, double angle_deg, int components = 1) {
  scene::Snapshot s{.time_s = 1.0, .stage = "pour", .materials = {"pellet", "sinter", "box"}};
  constexpr double kRadius = 0.005, kBase = 0.2;
  const double slope = std::tan(angle_deg * M_PI / 180.0);
  for (double x = -kBase; x <= kBase; x += 0.002)
    for (double z = kRadius; z <= std::max((kBase - std::abs(x)) * slope, kRadius); z += 0.004) {
      s.id.push_back(static_cast<std::int64_t>(s.id.size()));
      s.position.push_back({x, 0.0, z});
    }
  s.body = s.id;
  for (const auto& x : s.position) s.material.push_back(components == 2 && x.x() > 0.0 ? 1 : 0);
  s.radius_m.assign(s.size(), kRadius);
  s.mass_kg.assign(s.size(), 0.001);
  s.velocity.assign(s.size(), scene::Vec3::Zero());
  s.angular_velocity = s.velocity;
  scene::Case c = dem_adapter::Drawdown::preset("quick").make_case({}, 1);
  c.walls.clear();  // no draw-down any more
  c.stages = {{.name = "pour", .duration_s = 1.0}};
  scene::RunWriter writer(folder, c);
  const std::vector<double> masses(scene::region_columns(c).size(), 0.0);
  for (const double t : {0.0, 1.0})
    writer.add_row(scene::SeriesRow{.time_s = t, .region_mass_kg = masses});
  writer.write_snapshot(s);
  writer.finish({.steps = 1, .time_step_s = 1.0, .engine = "none", .version = "1"});
}

TEST(MeasureCommand, GivesTheAngleOfAPhotographWithAnAuditPicture) {
  const Workbench bench;
  for (const char* name : {"heap.png", "heap.jpg"}) {
    draw_cone(bench, name, 31.0);
    const auto said = bench.run(
        "repose", std::string("measure ") + name + " --scale 0.0005 --audit audit.svg --json");
    ASSERT_EQ(said.code, 0) << said.err;
    const auto json = nlohmann::json::parse(said.out);
    EXPECT_NEAR(json["kpis"]["angle_of_repose_deg"].get<double>(), 31.0, 0.1) << name;
    EXPECT_NEAR(json["details"]["heap_height_m"].get<double>(), 0.110, 0.002);
    EXPECT_NE(test::text_of(bench / "audit.svg").find(name), std::string::npos);
  }
  const auto level = bench.run("repose", "measure heap.png --level 0,290,600,290 --json");
  ASSERT_EQ(level.code, 0) << level.err;
  EXPECT_EQ(nlohmann::json::parse(level.out)["details"]["tilt_deg"], 0.0);
  const auto text =
      bench.run("repose", "measure heap.png --crop 50,20,500,280 --axis 300 --floor 290");
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_EQ(text.out.find("angle_of_repose_deg"), 0U) << text.out;
  EXPECT_NE(text.out.find("heap_height_px"), std::string::npos);
}

TEST(MeasureCommand, GivesTheAngleOfARunByTheSameMethod) {
  const Workbench bench;
  write_heap_run(bench / "run", 27.0);
  const auto said = bench.run("repose", "measure run --audit audit.svg --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const auto json = nlohmann::json::parse(said.out);
  // Of spheres of 10 mm over a half base of 200 mm.
  EXPECT_NEAR(json["kpis"]["angle_of_repose_deg"].get<double>(), 27.0, 0.5 * 0.05 * 180.0 / M_PI);
  EXPECT_EQ(bench.run("repose", "measure run/run.h5 --json").out, said.out);
  EXPECT_EQ(bench.run("repose", "measure run --snapshot pour --view front --json").out, said.out);
  EXPECT_EQ(bench.run("repose", "measure run --snapshot 2").code, 3);
  EXPECT_EQ(bench.run("repose", "measure run --window 5,5,6,6").code, 3);
}

TEST(MeasureCommand, GivesSegregationOverBinsWithItsSensitivityToTheirSize) {
  const Workbench bench;
  write_heap_run(bench / "run", 27.0, 2);  // of two components, one left of the other
  const auto said =
      bench.run("repose", "measure run --grid x --bin 0.1,0.05 --origin 0,0,0 -o bins.csv --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const auto json = nlohmann::json::parse(said.out);
  EXPECT_NEAR(json["kpis"]["rsd_x_pellet"].get<double>(), std::sqrt(4.0 / 3.0), 0.01);  // pure bins
  EXPECT_NEAR(json["sizes"]["rsd_pellet"][1].get<double>(), std::sqrt(8.0 / 7.0), 0.01);
  EXPECT_NEAR(json["details"]["li_pellet"].get<double>(), 1.0, 0.01);
  EXPECT_EQ(table::read_table({bench / "bins.csv", ""}).rows(), 4U);
  const auto still =
      bench.run("repose", "measure run --grid x --bin 0.1 --initial pour --snapshot 1 --json");
  ASSERT_EQ(still.code, 0) << still.err;
  EXPECT_EQ(nlohmann::json::parse(still.out)["details"]["center_of_mass_shift_pellet"], 0.0);
  const auto text = bench.run("repose", "measure run --grid x --bin 0.1,0.05");
  EXPECT_NE(text.out.find("grains_per_bin"), std::string::npos);
  const auto slices = bench.run("repose", "measure run --slices 6,3 --json");
  ASSERT_EQ(slices.code, 0) << slices.err;
  EXPECT_GT(nlohmann::json::parse(slices.out)["kpis"]["rsd_image_horizontal_pellet"].get<double>(),
            0.9);
  for (const char* wrong :
       {"--grid x --bin 9", "--grid x --bin 0", "--bin 0.1", "--over-time nowhere",
        "--grid x --axis 0", "--grid radial --over-time upper_box", "-o a.csv",
        "--grid x --box 0,0,0,0,0,0", "--grid x --box 8,8,8,9,9,9", "--initial 1",
        "--grid x --bin 0.1 --initial 2", "--over-time upper_box --initial settled",
        "--level 0,0,100,0"}) {
    const auto refused = bench.run("repose", std::string("measure run ") + wrong);
    EXPECT_EQ(refused.code, 3) << wrong << refused.err;
    EXPECT_EQ(refused.out, "");
  }
  EXPECT_EQ(bench.run("repose", "measure run --grid diagonal").code, 2);
}

TEST(MeasureCommand, GivesTheFlowOfALoadCellAndTheDensityOfARun) {
  const Workbench bench;
  std::string csv = "time_s,mass_kg\n";
  for (int i = 0; i <= 100; ++i)
    csv += std::to_string(0.02 * i) + "," + std::to_string(30.0 - 12.0 * 0.02 * i) + "\n";
  bench.write("cell.csv", csv);
  const auto flow = bench.run("repose", "measure cell.csv --flow mass_kg --json");
  ASSERT_EQ(flow.code, 0) << flow.err;
  EXPECT_NEAR(nlohmann::json::parse(flow.out)["kpis"]["mass_flow_kg_s"].get<double>(), 12.0, 1e-4);
  EXPECT_EQ(bench.run("repose", "measure cell.csv --flow mass_kg --flow-window 0.5,1.5").code, 0);
  EXPECT_EQ(bench.run("repose", "measure cell.csv --flow mass_kg --flow-window 5,6").code, 5);
  bench.write("two.csv", "time_s,mass_kg\n0,10\n1,5\n");
  const auto two = bench.run("repose", "measure two.csv --flow mass_kg");
  EXPECT_EQ(two.code, 3);
  EXPECT_NE(two.err.find("2 points, at least 3 are needed"), std::string::npos) << two.err;
  for (const char* wrong : {"", "--flow weight", "--flow mass_kg --scale 1",
                            "--flow mass_kg --stage a", "--flow mass_kg --flow-window 2,1"})
    EXPECT_EQ(bench.run("repose", std::string("measure cell.csv ") + wrong).code, 3) << wrong;
  write_heap_run(bench / "run", 27.0);
  const auto density =
      bench.run("repose", "measure run --bulk-density --box -0.05,0,0.01,0.05,0.02,0.05 --json");
  ASSERT_EQ(density.code, 0) << density.err;
  const auto json = nlohmann::json::parse(density.out);
  // Spheres of 1 g every 2 mm across and 4 mm up.
  EXPECT_NEAR(json["kpis"]["bulk_density_kg_m3"].get<double>(), 0.001 / (0.002 * 0.004 * 0.02),
              800.0);
  for (const char* wrong :
       {"--bulk-density", "--contacts", "--flow nowhere", "--contacts --bulk-density",
        "--stage pour", "--flow upper_box --box 0,0,0,1,1,1"})
    EXPECT_EQ(bench.run("repose", std::string("measure run ") + wrong).code, 3) << wrong;
}

TEST(MeasureCommand, RefusesWhatIsNoPictureWithASentenceAndCodeThree) {
  const Workbench bench;
  draw_cone(bench, "good.png", 30.0);
  const std::string good = test::text_of(bench / "good.png");
  bench.write("empty.png", "");
  bench.write("text.png", "no picture at all, but some words");
  test::write_bytes(bench / "half.png", good.substr(0, good.size() / 2));
  for (const char* arguments :
       {"empty.png", "text.png", "half.png", "good.png --crop 0,0,601,300",
        "good.png --background '#12'", "good.png --background text.png", "good.png --threshold 999",
        "good.png --axis 5000", "good.png --shape slopes", "good.png --window 0,0,1,1",
        "good.png --from 0.9 --to 0.1", "good.png --floor 5000", "good.png --outlet 200,300",
        "good.png --shape slopes --outlet 300,200",
        "good.png --shape slopes --outlet 200,300 --axis 250", "good.png --level 10,5,20,5",
        "good.png --initial 1"}) {
    const auto said = bench.run("repose", std::string("measure ") + arguments);
    EXPECT_EQ(said.code, 3) << arguments << "\n" << said.err;
    EXPECT_GT(said.err.size(), 40U) << arguments;
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_EQ(said.out, "") << arguments;
  }
  EXPECT_EQ(bench.run("repose", "measure missing.png").code, 6);
  EXPECT_EQ(bench.run("repose", "measure .").code, 6);
  for (const char* wrong : {"", "good.png --scale 0", "good.png --shape cone",
                            "good.png --crop 1,2", "good.png --component pellet"})
    EXPECT_EQ(bench.run("repose", std::string("measure ") + wrong).code, 2) << wrong;
}

TEST(MeasureCommand, WritesNoAuditPictureWhereItMeasuredNothing) {
  const Workbench bench;
  draw_cone(bench, "good.png", 30.0);
  EXPECT_EQ(bench.run("repose", "measure good.png --axis 2 --audit audit.svg").code, 3);
  EXPECT_EQ(bench.files(), 1U);
  EXPECT_EQ(bench.run("repose", "measure good.png --audit nowhere/audit.svg").code, 6);
}

}  // namespace
}  // namespace repose
