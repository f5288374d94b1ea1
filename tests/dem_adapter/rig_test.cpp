// Rigs in TOML: expressions, what is checked, and where mistakes are reported.
#include "repose/dem_adapter/rig.hpp"

#include <gtest/gtest.h>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/scenario.hpp"
#include "repose/dem_adapter/shipped_scenarios.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

/// A box into which grains fall; lines count from 1.
constexpr char kRig[] = R"toml(scenario = "rig"
[parameters]
width_m = 0.1
mu = 0.4
limit_s = 0.5
[derived]
half_m = "= width_m / 2"
high_m = "= 4 * half_m"
[domain]
lower_m = ["= -width_m", "= -width_m", -0.1]
upper_m = ["= width_m", "= width_m", "= 2 * high_m"]
[[material]]
name = "glass"
density_kg_m3 = 2500
youngs_modulus_pa = 1e7
poissons_ratio = 0.25
[[pair]]
materials = ["glass", "glass"]
restitution = 0.8
mu_s = "= mu"
mu_r = "= 0.1 * mu ^ 2"
[[box]]
name = "bin"
material = "glass"
lower_m = ["= -half_m", "= -half_m", 0]
upper_m = ["= half_m", "= half_m", "= high_m"]
open = ["+z"]
[[region]]
name = "bin"
z_above_m = 0
z_below_m = "= high_m"
[fill]
lower_m = ["= -half_m", "= -half_m", 0]
upper_m = ["= half_m", "= half_m", "= high_m"]
[[fill.layer]]
mass_kg = 0.05
material = "glass"
sizes = [{ diameter_m = "= width_m / 12" }]
[[stage]]
name = "settle"
duration_s = "= max(0.1, limit_s)"
[[kpi]]
name = "filled_kg"
kind = "mass"
region = "bin"
[[kpi]]
name = "filled_per_width"
kind = "formula"
formula = "= filled_kg / width_m + 0 * half_m"
)toml";

/// The text with one line replaced, counted from 1.
std::string with_line(int line, const std::string& by) {
  std::string text = kRig;
  std::size_t from = 0;
  for (int k = 1; k < line; ++k) from = text.find('\n', from) + 1;
  return text.replace(from, text.find('\n', from) - from, by);
}

Rig rig_of(const std::string& text) {
  const auto table = TomlTable::parse(text, "rig.toml");
  Rig rig = Rig::read(table);
  table.refuse_unknown_keys();
  return rig;
}

std::string message_of(const std::string& text) {
  try {
    rig_of(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

void expect_said(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message << "\n  lacks\n" << part;
}

TEST(Rig, PutsParametersIntoTheCase) {
  const Rig rig = rig_of(kRig);
  EXPECT_EQ(rig.parameter_names(), (std::vector<std::string>{"limit_s", "mu", "width_m"}));
  EXPECT_EQ(rig.kpi_names(), (std::vector<std::string>{"filled_kg", "filled_per_width"}));
  const auto scene = rig.make_case({{"width_m", 0.2}, {"someone_elses", 7.0}}, 11);
  EXPECT_EQ(scene.seed, 11u);
  EXPECT_EQ(scene.upper_m.x(), 0.2);
  EXPECT_EQ(scene.upper_m.z(), 0.8);
  EXPECT_EQ(scene.pairs[0].mu_s, 0.4);
  EXPECT_DOUBLE_EQ(scene.pairs[0].mu_r, 0.1 * 0.4 * 0.4);
  EXPECT_EQ(std::get<std::vector<scene::SizeClass>>(scene.fill->layers[0].mixture[0].sizes)[0]
                .lower_diameter_m,
            0.2 / 12.0);
  EXPECT_EQ(scene.parameters,
            (std::map<std::string, double>{{"limit_s", 0.5}, {"mu", 0.4}, {"width_m", 0.2}}));
}

TEST(Rig, IsTheCaseThatTheSameFileWithNumbersGives) {
  std::string text = kRig;
  const auto replace_all = [&](const std::string& what, const std::string& by) {
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what))
      text.replace(at, what.size(), by);
  };
  for (const auto& [what, by] : std::vector<std::pair<std::string, std::string>>{
           {"scenario = \"rig\"\n", ""},
           {"[derived]\nhalf_m = \"= width_m / 2\"\nhigh_m = \"= 4 * half_m\"\n", ""},
           {"\"= -width_m\"", "-0.1"},
           {"\"= width_m\"", "0.1"},
           {"\"= 2 * high_m\"", "0.4"},
           {"\"= mu\"", "0.4"},
           {"\"= 0.1 * mu ^ 2\"", "0.016000000000000004"},
           {"\"= -half_m\"", "-0.05"},
           {"\"= half_m\"", "0.05"},
           {"\"= high_m\"", "0.2"},
           {"\"= width_m / 12\"", "0.008333333333333333"},
           {"\"= max(0.1, limit_s)\"", "0.5"}})
    replace_all(what, by);
  text.erase(text.find("[[kpi]]"));
  EXPECT_EQ(scene::case_text(rig_of(kRig).make_case({}, 1)),
            scene::case_text(scene::parse_case(text, "case.toml")));
}

TEST(Rig, ReportsMistakesWithFileLineKeyAndExpression) {
  expect_said(message_of(with_line(20, "mu_s = \"= muh\"")),
              "rig.toml:20: pair[1].mu_s: \"= muh\": there is no muh; did you mean mu?");
  expect_said(message_of(with_line(20, "mu_s = \"= mu - 1\"")),
              "rig.toml:20: pair[1].mu_s: \"= mu - 1\" = -0.6 is not allowed");
  expect_said(message_of(with_line(20, "mu_s = \"= mu / 0\"")),
              "rig.toml:20: pair[1].mu_s: \"= mu / 0\" = inf is not finite");
  expect_said(message_of(with_line(20, "mu_s = \"= mu +\"")), "rig.toml:20: pair[1].mu_s: ");
  expect_said(message_of(with_line(20, "mu_s = \"= mu, 3\"")), "rig.toml:20: pair[1].mu_s: ");
  expect_said(message_of(with_line(20, "mu_s = \"= mu = 3\"")), "must not assign");
  expect_said(message_of(with_line(20, "mu_s = \"mu\"")), "must be a number or an expression");
  expect_said(message_of(with_line(8, "high_m = \"= 4 * half\"")),
              "rig.toml:8: derived.high_m: \"= 4 * half\": there is no half; did you mean half_m?");
  expect_said(message_of(with_line(4, "sin = 0.4")), "rig.toml:4: parameters.sin: ");
  expect_said(message_of(with_line(4, "mu = \"= 0.4\"")),
              "rig.toml:4: parameters.mu: must be a number");
  expect_said(message_of(with_line(4, "mu = 0.4\nspare = 1")),
              "rig.toml:5: parameters.spare: no expression uses it");
  expect_said(message_of(with_line(8, "high_m = \"= 4 * half_m\"\nspare = \"= mu\"")),
              "rig.toml:9: derived.spare: no expression uses it");
  expect_said(message_of(with_line(7, "mu = \"= width_m / 2\"")), "two of the name mu");
}

TEST(Rig, IsCheckedAsACaseIs) {
  expect_said(message_of(with_line(18, "materials = [\"glass\", \"steel\"]")), "steel");
  expect_said(message_of(with_line(16, "poissons_ratio = 0.25\nmodulus = 3")),
              "rig.toml:17: material[1].modulus: unknown key");
  expect_said(message_of(with_line(19, "restitution = \"= 3 * mu\"")), "restitution");
  expect_said(message_of(with_line(9, "[run]\nseed = 3\n[domain]")),
              "rig.toml:10: run.seed: a rig has no seed of its own");
}

TEST(Rig, ValuesOutOfRangeAreReportedWhenTheCaseIsMade) {
  const Rig rig = rig_of(kRig);
  try {
    rig.make_case({{"mu", -1.0}}, 1);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    expect_said(error.what(), "rig.toml:20: pair[1].mu_s: \"= mu\" = -1 is not allowed");
  }
}

TEST(RigKpis, HaveATextThatChangesWithThemAndWithNothingElse) {
  const auto definition = [](const std::string& text) { return rig_of(text).kpi_definition(); };
  const auto first = definition(kRig);
  EXPECT_EQ(definition(with_line(4, "mu = 0.5")), first);
  EXPECT_EQ(definition(with_line(14, "density_kg_m3 = 2600")), first);
  EXPECT_NE(definition(with_line(45, "region = \"bin\"\ntime_s = 0.1")), first);
  EXPECT_NE(definition(with_line(45, "region = \"bin\"\ntime_s = 0.1")),
            definition(with_line(45, "region = \"bin\"\ntime_s = \"= mu\"")));
  EXPECT_NE(definition(with_line(49, "formula = \"= 2 * filled_kg + 0 * half_m\"")), first);
  EXPECT_NE(definition(with_line(8, "high_m = \"= 2 * width_m\"")), first);
  const auto angle = [&](const std::string& axis) {
    return definition(with_line(44, "kind = \"mass\"") + "[[kpi]]\nname = \"x\"\nkind = " +
                      "\"grid_segregation\"\ngrid = \"x\"\nmaterial = \"glass\"\norigin_m = [0, " +
                      axis + ", 0]\n");
  };
  EXPECT_NE(angle("0.1"), angle("0.2"));
  EXPECT_NE(angle("\"= mu\""), angle("\"= half_m\""));
}

TEST(RigKpis, AreCheckedAgainstTheCase) {
  expect_said(message_of(with_line(45, "region = \"bim\"")),
              "filled_kg: there is no region \"bim\"; did you mean bin?");
  expect_said(message_of(with_line(45, "region = \"bim\"")), "rig.toml:42: kpi[1]");
  expect_said(
      message_of(with_line(43, "name = \"filled_g\"")),
      "rig.toml:43: kpi[1].name: \"filled_g\": the name of a KPI of kind mass must end with "
      "its unit, _kg");
  expect_said(message_of(with_line(43, "name = \"filled_kg_s\"")), "must end with its unit, _kg");
  expect_said(message_of(with_line(44, "kind = \"masss\"")), "rig.toml:44: kpi[1].kind: ");
  expect_said(message_of(with_line(45, "region = \"bin\"\nstag = 3")),
              "rig.toml:46: kpi[1].stag: unknown key; did you mean stage?");
  expect_said(message_of(with_line(47, "name = \"filled_kg\"")), "two KPIs are called filled_kg");
  expect_said(message_of(with_line(47, "name = \"mu\"")), "two of the name mu");
  expect_said(message_of(with_line(49, "formula = \"= filled_kg / depth_m\"")),
              "filled_per_width: there is no depth_m");
  expect_said(message_of(with_line(49, "formula = \"filled_kg\"")), "must begin with =");
}

TEST(Rig, FindsItsFilesBesideItsOwn) {
  const test::TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "rigs");
  write_file_atomically(folder / "rigs/grains.csv", "x_m,y_m,z_m,radius_m\n0,0,0.01,0.004\n");
  std::string text = kRig;
  text.insert(text.find("[[stage]]"),
              "[[particle_table]]\nfile = \"grains.csv\"\nmaterial = \"glass\"\n");
  write_file_atomically(folder / "rigs/rig.toml", text);
  write_file_atomically(folder / "study.toml", "scenario = \"rigs/rig.toml\"\n");
  const auto study = TomlTable::read_file(folder / "study.toml");
  const auto scenario = read_scenario_key(study, folder.path());
  expect_said(scenario.make_input({}, 1).text, (folder / "rigs/grains.csv").string());
}

TEST(Rig, StandsInAStudyAsATable) {
  std::string text = kRig;
  std::string inner = "[scenario]\n" + text;
  for (const char* table : {"parameters", "derived", "domain", "fill"}) {
    const std::string head = "[" + std::string(table) + "]";
    inner.replace(inner.find("\n" + head) + 1, head.size(),
                  "[scenario." + std::string(table) + "]");
  }
  for (auto at = inner.find("[["); at != std::string::npos; at = inner.find("[[", at + 2))
    inner.insert(at + 2, "scenario.");
  const auto study = TomlTable::parse(inner, "study.toml");
  const auto scenario = read_scenario_key(study, {});
  study.refuse_unknown_keys();
  EXPECT_EQ(scenario.make_input({}, 3).text, scene::case_text(rig_of(text).make_case({}, 3)));
}

TEST(HowTo, OfScenariosShowsARigThatIsValid) {
  const auto page = read_file(REPOSE_SOURCE_DIR "/docs/how-to/scenarios.md");
  const std::string begin = "```toml\n";
  const auto from = page.find(begin) + begin.size();
  const auto rig = rig_of(page.substr(from, page.find("```", from) - from));
  EXPECT_EQ(rig.kpi_names(), std::vector<std::string>{"bulk_density_kg_m3"});
}

TEST(ShippedScenarios, AreReadAndMakeValidCases) {
  ASSERT_FALSE(shipped_scenarios().empty());
  for (const auto& shipped : shipped_scenarios()) {
    const auto table = TomlTable::parse(shipped.text, shipped.name);
    const auto scenario = read_scenario(table);
    table.refuse_unknown_keys();
    EXPECT_FALSE(scenario.kpi_names().empty()) << shipped.name;
    EXPECT_FALSE(shipped.summary.empty()) << shipped.name;
    EXPECT_NO_THROW(scenario.make_input({}, 1)) << shipped.name;
    const auto by_name =
        TomlTable::parse("scenario = \"" + shipped.name + "\"\n", "two_lines.toml");
    EXPECT_NO_THROW(read_scenario(by_name)) << shipped.name;
  }
  EXPECT_THROW(shipped_scenario("hoper"), InputError);
}

TEST(ShippedScenarios, TakeOtherDefaultsByTheirParameters) {
  const auto read = [](const std::string& parameters) {
    const auto table =
        TomlTable::parse("scenario = \"hopper\"\n[parameters]\n" + parameters, "mine.toml");
    auto scenario = read_scenario(table);
    table.refuse_unknown_keys();
    return scenario;
  };
  expect_said(read("outlet_m = 0.04\n").make_input({}, 1).text, "outlet_m = 0.04\n");
  const auto said = [&](const std::string& parameters) -> std::string {
    try {
      read(parameters);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  expect_said(said("outlet = 0.04\n"), "mine.toml:3: parameters.outlet: ");
  expect_said(said("outlet_m = 0.5\n"), "mine.toml:2: parameters: ");
  expect_said(said("outlet_m = 0.04\n[fill]\nx = 1\n"), "mine.toml:4: fill: unknown key");
}

}  // namespace
}  // namespace repose::dem_adapter
