// A user's own command as a scenario: placeholders, extractors, echoes, and what goes wrong.
#include "repose/dem_adapter/command.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/campaign.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

/// A folder with the files of a scenario.
class Bench {
 public:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }
  fs::path operator/(const std::string& name) const { return folder_ / name; }
  Scenario scenario(const std::string& text) const {
    write("scenario.toml", "scenario = \"command\"\n" + text);
    return read_scenario_file(folder_ / "scenario.toml");
  }
  /// The message with which it is refused.
  std::string refusal(const std::string& text) const {
    try {
      static_cast<void>(scenario(text));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }
  /// A run in RUNS/N, and its exit.
  EngineExit run(const Scenario& scenario, const ParameterValues& values, std::uint64_t seed,
                 int ranks = 1) {
    run_ = folder_ / ("run" + std::to_string(++runs_));
    fs::create_directories(run_);
    write_file_atomically(run_ / "case.toml", scenario.make_input(values, seed).text);
    return scenario.own_engine(LocalExecutor())->run({.directory = run_, .ranks = ranks});
  }
  fs::path output() const { return run_ / "output"; }
  std::string log() const { return read_file(run_ / "engine.log"); }

 private:
  test::TemporaryDirectory folder_;
  fs::path run_;
  int runs_ = 0;
};

/// Says what it was given, and its double as the KPI.
constexpr auto kEchoing = R"(
command = ["sh", "in.sh", "${seed}"]
templates = ["in.sh"]
[parameters]
mu = 0.5
[[kpi]]
name = "twice"
pattern = 'twice ([0-9.e+-]+)'
[echo]
mu = { pattern = 'mu ([0-9.e+-]+)' }
)";

TEST(CommandScenario, FillsInTemplatesAndArgumentsAndReadsWhatTheCommandSays) {
  Bench bench;
  bench.write("in.sh",
              "echo mu ${mu}\necho seed $1\necho plain $${mu}\n"
              "awk 'BEGIN { print \"twice\", 2 * ${mu} }'\n");
  const auto scenario = bench.scenario(kEchoing);
  EXPECT_EQ(scenario.parameter_names(), std::vector<std::string>{"mu"});
  EXPECT_EQ(scenario.kpi_names(), std::vector<std::string>{"twice"});
  const auto exit = bench.run(scenario, {{"mu", 0.25}, {"of a tie", 3.0}}, 77);
  ASSERT_EQ(exit.status, EngineStatus::finished) << exit.message;
  EXPECT_EQ(bench.log(), "mu 0.25\nseed 77\nplain\ntwice 0.5\n");
  const auto m = scenario.measure(bench.output());
  EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
  EXPECT_EQ(m.kpis.at("twice"), 0.5);
  ASSERT_EQ(bench.run(scenario, {}, 1).status, EngineStatus::finished);
  EXPECT_EQ(scenario.measure(bench.output()).kpis.at("twice"), 1.0);  // the default
}

TEST(CommandScenario, KeepsAllDigitsOfAParameter) {
  Bench bench;
  bench.write("in.txt", "${mu}");
  const auto scenario = bench.scenario(
      "command = [\"sh\", \"-c\", \"cat in.txt\"]\ntemplates = [\"in.txt\"]\n"
      "[parameters]\nmu = 0.5\n[[kpi]]\nname = \"mu_out\"\npattern = '(.+)'\n"
      "[echo]\nmu = { pattern = '(.+)', tolerance = 0 }\n");
  for (const double mu : {0.1 + 0.2, 1e-17, -3.0, 1.7976931348623157e308}) {
    bench.run(scenario, {{"mu", mu}}, 1);
    const auto m = scenario.measure(bench.output());
    EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
    EXPECT_EQ(m.kpis.at("mu_out"), mu);
  }
  EXPECT_THROW(scenario.make_input({{"mu", std::nan("")}}, 1), InputError);
}

TEST(CommandScenario, GivesEnginesASeedOf31Bits) {
  Bench bench;
  const auto scenario = bench.scenario(
      "command = [\"echo\", \"${seed_31}\"]\n[parameters]\n"
      "[[kpi]]\nname = \"seed_out\"\npattern = '(.+)'\n");
  for (const std::uint64_t seed : {0UL, 1UL, 2147483646UL, 9223372036854775807UL}) {
    bench.run(scenario, {}, seed);
    const double given = scenario.measure(bench.output()).kpis.at("seed_out");
    EXPECT_GE(given, 1.0) << seed;
    EXPECT_LT(given, 2147483647.0) << seed;
  }
}

TEST(CommandScenario, FindsNumbersInJsonTablesAndTexts) {
  Bench bench;
  bench.write("out.json", R"({"a": {"b": [1.5, 2.5]}, "none": null})");
  bench.write("out.csv", "t,flow\n0,4\n1,1\n2,7\n");
  bench.write("out.txt", "step 1: 10 J\nstep 2: +2e1 J\n");
  const auto scenario = bench.scenario(
      "command = [\"true\"]\nfiles = [\"out.json\", \"out.csv\", \"out.txt\"]\n[parameters]\n"
      "[[kpi]]\nname = \"json\"\nfile = \"out.json\"\npointer = \"/a/b/1\"\n"
      "[[kpi]]\nname = \"undefined\"\nfile = \"out.json\"\npointer = \"/none\"\n"
      "[[kpi]]\nname = \"first\"\nfile = \"out.csv\"\ncolumn = \"flow\"\nrow = \"first\"\n"
      "[[kpi]]\nname = \"last\"\nfile = \"out.csv\"\ncolumn = \"flow\"\nrow = \"last\"\n"
      "[[kpi]]\nname = \"mean\"\nfile = \"out.csv\"\ncolumn = \"flow\"\nrow = \"mean\"\n"
      "[[kpi]]\nname = \"min\"\nfile = \"out.csv\"\ncolumn = \"flow\"\nrow = \"min\"\n"
      "[[kpi]]\nname = \"max\"\nfile = \"out.csv\"\ncolumn = \"flow\"\nrow = \"max\"\n"
      "[[kpi]]\nname = \"one\"\nfile = \"out.txt\"\npattern = 'step 1: (.+) J'\n"
      "[[kpi]]\nname = \"final\"\nfile = \"out.txt\"\npattern = 'step (\\d+): (\\S+) J'\n"
      "group = 2\nmatch = \"last\"\n");
  bench.run(scenario, {}, 1);
  const auto m = scenario.measure(bench.output());
  EXPECT_EQ(m.kpis, (std::map<std::string, double>{{"json", 2.5},
                                                   {"first", 4.0},
                                                   {"last", 7.0},
                                                   {"mean", 4.0},
                                                   {"min", 1.0},
                                                   {"max", 7.0},
                                                   {"one", 10.0},
                                                   {"final", 20.0}}));
  EXPECT_EQ(m.outcome, Outcome::kpi_undefined);
  EXPECT_NE(m.failure.find("undefined is undefined"), std::string::npos) << m.failure;
}

TEST(CommandScenario, MeasuresTheAngleOfAConeOfParticles) {
  // A cone of 30 degrees in spheres of 1 mm on a square grid of 1 mm: in front view the upper edge
  // follows the slope to half a sphere over a base of 60 spheres a side.
  Bench bench;
  std::string table = "x_m,y_m,z_m,radius_m\n";
  const double slope = std::tan(30.0 * M_PI / 180.0);
  for (int i = -60; i <= 60; ++i)
    for (double z = 0.5e-3; z <= slope * (60 - std::abs(i)) * 1e-3; z += 1e-3)
      table += fmt::format("{},0,{},0.0005\n", i * 1e-3, z);
  bench.write("cone.csv", table);
  const auto scenario = bench.scenario(
      "command = [\"true\"]\nfiles = [\"cone.csv\"]\n[parameters]\n"
      "[[kpi]]\nname = \"angle_of_repose_deg\"\nfile = \"cone.csv\"\nshape = \"heap\"\n"
      "floor_m = 0.0\nfrom = 0.1\nto = 0.9\n");
  bench.run(scenario, {}, 1);
  EXPECT_NEAR(scenario.measure(bench.output()).kpis.at("angle_of_repose_deg"), 30.0, 1.0);
}

TEST(CommandScenario, CallsANumberThatIsMissingOrThereTwiceByItsKpi) {
  Bench bench;
  bench.write("out.json", "{\"a\": \"text\", \"b\": 1}");
  bench.write("nan.json", "{\"a\": NaN}");
  bench.write("out.csv", "flow\n1\n2\n");
  bench.write("out.txt", "angle 1\nangle 2\nangle x\n" + std::string(5000, 'a') + "\n");
  const std::tuple<const char*, const char*, const char*> kWrong[] = {
      {"none.json", "pointer = \"/a\"", "KPI angle: the command left no file none.json"},
      {"out.json", "pointer = \"/c\"", "KPI angle: out.json has no /c"},
      {"out.json", "pointer = \"/b/0\"", "KPI angle: out.json has no /b/0"},
      {"out.json", "pointer = \"/a\"", "KPI angle: out.json: /a is a text, not a number"},
      {"nan.json", "pointer = \"/a\"", "where there is no value write null, not NaN"},
      {"out.csv", "column = \"angle\"", "angle"},
      {"out.csv", "column = \"flow\"", "KPI angle: out.csv has 2 rows; choose one"},
      {"out.json", "pattern = '(\\d)\\d'", "KPI angle: out.json has nothing that matches"},
      {"out.txt", "pattern = '(.)'", "line 4 of out.txt has 5000 bytes"},
  };
  for (const auto& [file, how, message] : kWrong) {
    const auto scenario = bench.scenario(fmt::format(
        "command = [\"true\"]\nfiles = [\"out.json\", \"nan.json\", \"out.csv\", \"out.txt\"]\n"
        "[parameters]\n[[kpi]]\nname = \"angle\"\nfile = \"{}\"\n{}\n",
        file, how));
    bench.run(scenario, {}, 1);
    try {
      scenario.measure(bench.output());
      ADD_FAILURE() << file << " " << how;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
  bench.write("out.txt", "angle 1\nangle 2\nangle x\n");
  for (const auto& [how, message] : {std::pair("pattern = 'angle (\\d)'", "has 2 places"),
                                     std::pair("pattern = 'angle (\\w)'\nmatch = \"last\"",
                                               "out.txt, line 3: \"x\" is not a number")}) {
    const auto scenario =
        bench.scenario(fmt::format("command = [\"true\"]\nfiles = [\"out.txt\"]\n[parameters]\n"
                                   "[[kpi]]\nname = \"angle\"\nfile = \"out.txt\"\n{}\n",
                                   how));
    bench.run(scenario, {}, 1);
    try {
      scenario.measure(bench.output());
      ADD_FAILURE() << how;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

TEST(CommandScenario, FailsARunWhoseEngineUsedAnotherValueThanItWasGiven) {
  Bench bench;
  bench.write("in.sh", "echo mu 0.5 # not ${mu}\necho twice 1\n");
  const auto scenario = bench.scenario(kEchoing);
  bench.run(scenario, {{"mu", 0.5 * (1.0 + 1e-10)}}, 1);
  EXPECT_EQ(scenario.measure(bench.output()).outcome, Outcome::finished);
  bench.run(scenario, {{"mu", 0.5 * (1.0 + 1e-8)}}, 1);
  const auto m = scenario.measure(bench.output());
  EXPECT_EQ(m.outcome, Outcome::engine_failed);
  EXPECT_EQ(m.failure,
            "the command says that it used mu = 0.5, but 0.500000005 was given; look where the "
            "placeholder stands in its input");
  EXPECT_TRUE(m.kpis.empty());
}

TEST(CommandScenario, NamesFailuresByWhatTheCommandSays) {
  Bench bench;
  const auto scenario = bench.scenario(
      "command = [\"sh\", \"-c\", \"echo ERROR: Lost atoms: 3; exit ${code}\"]\n"
      "[parameters]\ncode = 1\n[[kpi]]\nname = \"k\"\npattern = '(\\d)'\n"
      "[outcomes]\nparticles-lost = \"Lost atoms\"\n");
  const auto exit = bench.run(scenario, {}, 1);
  EXPECT_EQ(exit.status, EngineStatus::failed);
  EXPECT_EQ(exit.failure, Outcome::particles_lost);
  EXPECT_EQ(exit.message, "ERROR: Lost atoms: 3");
  EXPECT_EQ(bench.run(scenario, {{"code", 0}}, 1).status, EngineStatus::finished);
  EXPECT_THROW(bench.run(scenario, {{"code", 127}}, 1), StorageError);  // as a shell says it
}

TEST(CommandScenario, RefusesWhatCouldNotWorkBeforeAnythingRuns) {
  Bench bench;
  bench.write("in.txt", "a\n${mu} ${mus}\n");
  bench.write("bad.txt", "a\nb ${mu s}\n");
  bench.write("plain.sh", "true\n");
  const std::string kpi = "[[kpi]]\nname = \"k\"\npattern = '(\\d)'\n";
  const auto refused = [&](const std::string& text, const std::string& message) {
    const auto said = bench.refusal(text);
    EXPECT_NE(said.find(message), std::string::npos) << text << "\n" << said;
  };
  const std::string parameters = "[parameters]\nmu = 1\n";
  refused("command = [\"true\"]\ntemplates = [\"in.txt\"]\n" + parameters + kpi,
          "in.txt, line 2: there is no parameter for ${mus}; did you mean mu?");
  refused("command = [\"true\"]\ntemplates = [\"bad.txt\"]\n" + parameters + kpi,
          "bad.txt, line 2: \"${mu s}\" is no placeholder");
  refused("command = [\"true\"]\n" + parameters + kpi,
          "parameters.mu: neither templates nor command");
  refused("command = [\"true\"]\ntemplates = [\"none.txt\"]\n" + parameters + kpi,
          "there is no file");
  refused("command = []\n" + parameters + kpi, "give the program");
  refused("command = [\"${mu}\"]\n" + parameters + kpi, "may not have placeholders");
  refused("command = [\"./plain.sh\", \"${mu}\"]\n" + parameters + kpi, "neither among files");
  refused("command = [\"./plain.sh\", \"${mu}\"]\nfiles = [\"plain.sh\"]\n" + parameters + kpi,
          "is not executable");
  refused("command = [\"echo\", \"${mu}\"]\n" + parameters, "there is no KPI");
  refused("command = [\"echo\", \"${mu}\"]\n[parameters]\nseed = 1\n" + kpi,
          "is there without a parameter");
  refused(
      "command = [\"echo\", \"${mu}\"]\n" + parameters + kpi + "[echo]\nmu_s = {pattern = '.'}\n",
      "there is no parameter of this name");
  refused("command = [\"echo\", \"${mu}\"]\n" + parameters + kpi + "[outcomes]\nlost = \"x\"\n",
          "no outcome of a run");
  for (const auto& [how, message] :
       {std::pair("", "say how the number is found"),
        std::pair("pointer = \"/a\"\ncolumn = \"b\"", "taken in one way"),
        std::pair("pointer = \"/a\"", "the key file is missing"),
        std::pair("file = \"a\"\npointer = \"a\"", "no JSON pointer"),
        std::pair("file = \"../a\"\npointer = \"/a\"", "give a relative path"),
        std::pair("pattern = '(a'", "no regular expression"),
        std::pair("pattern = 'a'", "the pattern has 0 groups")})
    refused(
        "command = [\"echo\", \"${mu}\"]\n" + parameters + "[[kpi]]\nname = \"k\"\n" + how + "\n",
        message);
}

TEST(CommandScenario, SaysWhichProgramIsMissing) {
  Bench bench;
  const auto scenario = bench.scenario(
      "command = [\"no_such_program_7\"]\n[parameters]\n[[kpi]]\nname = \"k\"\npattern = '(.)'\n");
  try {
    static_cast<void>(scenario.own_engine(LocalExecutor()));
    ADD_FAILURE();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("no_such_program_7"), std::string::npos);
  }
}

TEST(CommandScenario, PassesRanksOnAndRefusesThemWhereNothingUsesThem) {
  Bench bench;
  const std::string kpi = "[parameters]\n[[kpi]]\nname = \"k\"\npattern = '(\\d)'\n";
  bench.run(bench.scenario("command = [\"echo\", \"${ranks}\"]\n" + kpi), {}, 1, 3);
  EXPECT_EQ(bench.log(), "3\n");
  EXPECT_THROW(bench.run(bench.scenario("command = [\"echo\", \"3\"]\n" + kpi), {}, 1, 3),
               InputError);
}

TEST(CommandScenario, IsNamedByCommandAndFilesButMeasuredByItsKpis) {
  Bench bench;
  bench.write("in.txt", "a");
  const auto made = [&](const std::string& command, const std::string& pattern) {
    return bench.scenario("command = [" + command + "]\nfiles = [\"in.txt\"]\n[parameters]\n" +
                          "[[kpi]]\nname = \"k\"\npattern = '" + pattern + "'\n");
  };
  const auto name_of = [](const Scenario& s) { return s.own_engine(LocalExecutor())->name(); };
  const auto first = made("\"echo\", \"1\"", "(\\d)");
  const auto other_kpi = made("\"echo\", \"1\"", "(\\d+)");
  EXPECT_EQ(name_of(first), name_of(other_kpi));
  EXPECT_NE(measure_of(first).name, measure_of(other_kpi).name);
  EXPECT_NE(name_of(first), name_of(made("\"echo\", \"2\"", "(\\d)")));
  bench.write("in.txt", "b");
  EXPECT_NE(name_of(first), name_of(made("\"echo\", \"1\"", "(\\d)")));
}

TEST(CommandScenario, KeepsItsFilesAsTheyWereWhenItWasRead) {
  Bench bench;
  bench.write("sub/in.sh", "echo old\n");
  const auto scenario = bench.scenario(
      "command = [\"sh\", \"sub/in.sh\"]\nfiles = [\"sub/in.sh\"]\n[parameters]\n"
      "[[kpi]]\nname = \"k\"\npattern = '(.)'\n");
  bench.write("sub/in.sh", "echo new\n");
  bench.run(scenario, {}, 1);
  EXPECT_EQ(bench.log(), "old\n");
}

}  // namespace
}  // namespace repose::dem_adapter
