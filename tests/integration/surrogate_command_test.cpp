// repose fit and predict, as a user runs them.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace repose::test {
namespace {

using nlohmann::json;

/// 36 rows: a stiffness over three decades, a friction, a shape; noise known, three materials.
std::string runs() {
  std::string csv = "young_pa,mu_s,shape,material,noise_variance,angle_deg,fraction\n";
  const char* shapes[] = {"sphere", "clump", "cube"};
  for (int i = 0; i < 36; ++i) {
    const double u = std::fmod(0.5 + 0.6180339887 * i, 1.0);
    const double v = std::fmod(0.25 + 0.7548776662 * i, 1.0);
    const double angle = 25.0 + 8.0 * v + std::sin(4.0 * u) + (i % 3) + 0.02 * ((i * 7) % 5 - 2);
    char line[200];
    std::snprintf(line, sizeof line, "%.6e,%.4f,%s,m%d,%.4f,%.4f,%.4f\n", 1e5 * std::pow(1e3, u),
                  0.2 + 0.6 * v, shapes[i % 3], i % 4, 0.001 + 0.001 * (i % 2), angle,
                  angle / 60.0);
    csv += line;
  }
  return csv;
}

json fitted(const Workbench& bench, const std::string& options) {
  const auto said = bench.run("repose", "fit runs.csv -o m.h5 --json " + options);
  EXPECT_EQ(said.code, 0) << said.err;
  return said.code == 0 ? json::parse(said.out) : json();
}

TEST(FitCommand, ReportsEveryParameterByNameAndState) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json fit = fitted(bench,
                          "--response angle_deg --input young_pa,mu_s,shape --log young_pa "
                          "--kernel ard-rational-quadratic --basis linear --noise "
                          "column:noise_variance --bound mu_s=0.5 --bound alpha=0.5:4");
  EXPECT_EQ(fit.at("rows"), 36);
  EXPECT_EQ(fit.at("kernel"), "ard-rational-quadratic");
  EXPECT_GT(fit.at("loo_q2"), 0.98);
  EXPECT_TRUE(fit.at("negative_log_likelihood").is_number());
  ASSERT_EQ(fit.at("parameters").size(), 5u);
  EXPECT_EQ(fit["parameters"][1]["meaning"], "length scale of mu_s");
  EXPECT_EQ(fit["parameters"][1]["state"], "fixed");
  EXPECT_EQ(fit["parameters"][3]["name"], "alpha");
  EXPECT_EQ(fit["parameters"][4]["name"], "process_variance");
}

TEST(FitCommand, SelectsAmongFortyModelsByWhatGroupsTell) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json fit = fitted(bench,
                          "--response angle_deg --input young_pa,mu_s,shape --log young_pa "
                          "--select --group material --starts 1");
  ASSERT_EQ(fit.at("candidates").size(), 40u);
  EXPECT_EQ(fit["candidates"][0]["kernel"], fit["kernel"]);
  EXPECT_EQ(fit["candidates"][0]["basis"], fit["basis"]);
  EXPECT_EQ(fit["candidates"][0]["log_density"], fit["loo_log_density"]);
  EXPECT_EQ(fit.at("left_out"), "groups");
}

TEST(FitCommand, SaysWhatIsWrongWithItsOptions) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const auto fails = [&](const std::string& options, int code, const std::string& word) {
    const auto said = bench.run("repose", "fit runs.csv --response angle_deg -o m.h5 " + options);
    EXPECT_EQ(said.code, code) << options;
    EXPECT_NE(said.err.find(word), std::string::npos) << said.err;
  };
  fails("--noise loud", 2, "loud");
  fails("--basis cubic", 2, "cubic");
  fails("--input mu_s --bound nothing=1", 3, "nothing");
  fails("--input mu_s --bound mu_s=x", 3, "mu_s=x");
  fails("--input mu_s --log shape", 3, "shape");
  fails("--input mu_s --response-scale logit", 3, "between 0 and 1");
  fails("--input mu_s --noise by-point", 3, "repeats");
}

TEST(PredictCommand, GivesGradientsFlagsAndRefusesUnknownLevels) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  fitted(bench,
         "--response fraction --input young_pa,mu_s,shape --log young_pa --response-scale logit "
         "--bound mu_s=0.3");
  bench.write("points.csv",
              "young_pa,mu_s,shape\n1e6,0.4,cube\n0.99e6,0.4,cube\n1.01e6,0.4,cube\n"
              "1e6,0.396,cube\n1e6,0.404,cube\n1e12,9,clump\n");
  const auto said = bench.run("repose", "predict m.h5 points.csv -o p.csv --gradient --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const json p = json::parse(said.out);
  const auto at = [&p](const char* column, std::size_t row) {
    return p.at(column).at(row).get<double>();
  };
  // central differences over 1 %: off by a third derivative times 1e-4
  const double by_young = (at("predicted", 2) - at("predicted", 1)) / 2e4;
  EXPECT_NEAR(at("predicted_by_young_pa", 0), by_young, 1e-2 * std::abs(by_young));
  const double by_mu = (at("predicted", 4) - at("predicted", 3)) / 8e-3;
  EXPECT_NEAR(at("predicted_by_mu_s", 0), by_mu, 1e-2 * std::abs(by_mu));
  EXPECT_EQ(at("predicted_by_shape", 0), 0.0);
  EXPECT_EQ(p.at("outside_range"), (json{0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(p.at("far_from_data"), (json{0, 0, 0, 0, 0, 1}));
  EXPECT_LT(at("predicted", 5), 1.0);  // a fraction stays one
  bench.write("points.csv", "young_pa,mu_s,shape\n1e6,0.4,torus\n");
  const auto refused = bench.run("repose", "predict m.h5 points.csv -o p.csv");
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.err.find("torus"), std::string::npos);
}

TEST(SensitivityCommand, TellsTheSharesAndWritesBothTables) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  fitted(bench, "--response angle_deg --input young_pa,mu_s,shape --log young_pa");
  const auto said = bench.run("repose", "sensitivity m.h5 --points 256 --draws 50 -o s.h5 --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const json s = json::parse(said.out).at("inputs");
  ASSERT_EQ(s.size(), 3u);
  EXPECT_EQ(s[1].at("name"), "mu_s");
  EXPECT_GT(s[1].at("total").at("value"), s[0].at("total").at("value"));
  double sum = 0.0;
  for (const auto& input : s) {
    EXPECT_LE(input.at("first").at("lower"), input.at("first").at("value"));
    sum += input.at("first").at("value").get<double>();
  }
  EXPECT_NEAR(sum, 1.0, 0.1);  // additive by construction
  EXPECT_EQ(s[2].at("partial_dependence").at("x"), (json{0.0, 1.0, 2.0}));
  EXPECT_EQ(bench.run("repose", "table show s.h5:/sobol").code, 0);
  EXPECT_EQ(bench.run("repose", "table show s.h5:/partial_dependence").code, 0);
  EXPECT_EQ(bench.run("repose", "sensitivity nothing.h5").code, 6);
}

TEST(ModelFile, IsReadByH5py) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "no h5py here";
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json fit = fitted(bench, "--response angle_deg --input young_pa,mu_s,shape --log young_pa");
  bench.write("read.py",
              "import h5py, json\n"
              "f = h5py.File('m.h5')\n"
              "print(json.dumps({'kernel': f.attrs['kernel'], 'version': int(f.attrs"
              "['model_version']), 'names': [n.decode() for n in f['inputs/name'][:]], "
              "'points': f['points/y'].shape[0], 'factor': f['factor/l'].shape[0]}))\n");
  ASSERT_EQ(
      std::system(
          ("cd '" + (bench / "").string() + "' && /usr/bin/python3 read.py > read.json").c_str()),
      0);
  const json read = json::parse(text_of(bench / "read.json"));
  EXPECT_EQ(read.at("kernel"), fit.at("kernel"));
  EXPECT_EQ(read.at("version"), 3);
  EXPECT_EQ(read.at("names"), fit.at("inputs"));
  EXPECT_EQ(read.at("points"), 36);
  EXPECT_EQ(read.at("factor"), 36 * 37 / 2);
}

/// Two responses of two parameters, known in closed form: a = 10 (x + y), b = 20 + 10 x - 5 y.
std::string plane(int rows) {
  std::string csv = "x,y,mode,a,b\n";
  for (int i = 0; i < rows; ++i) {
    const double x = std::fmod(0.5 + 0.7548776662 * i, 1.0);
    const double y = std::fmod(0.5 + 0.5698402910 * i, 1.0);
    char line[160];
    std::snprintf(line, sizeof line, "%.6f,%.6f,%s,%.8f,%.8f\n", x, y, i % 2 == 0 ? "wet" : "dry",
                  10.0 * (x + y) + (i % 2 == 0 ? 0.0 : 3.0), 20.0 + 10.0 * x - 5.0 * y);
    csv += line;
  }
  return csv;
}

/// Models of a and b over x, y (and mode).
void fit_plane(const Workbench& bench, const std::string& inputs = "x,y") {
  bench.write("plane.csv", plane(24));
  for (const char* response : {"a", "b"}) {
    const auto said = bench.run("repose", std::string("fit plane.csv --input ") + inputs +
                                              " --noise none --basis linear --response " +
                                              response + " -o " + response + ".h5");
    ASSERT_EQ(said.code, 0) << said.err;
  }
}

json said_json(const Workbench& bench, const std::string& command) {
  const auto said = bench.run("repose", command + " --json");
  EXPECT_EQ(said.code, 0) << said.err;
  return said.code == 0 ? json::parse(said.out) : json();
}

// b has no part of mode: 20 + 10 x - 5 y = 21.5 and 10 (x + y) + 3 = 13 give x = 13/30, y = 17/30.
TEST(OptimiseCommand, FindsTheParametersThatMeetBothTargets) {
  const Workbench bench;
  fit_plane(bench, "x,y,mode");
  for (const std::string method : {"cma-es --evaluations 4000", "ga --population 200"}) {
    const json found = said_json(bench,
                                 "optimise a.h5 b.h5 --target a=13 --target b=21.5 --weight b=2 "
                                 "--fix mode=dry --repeat 3 --loss squared -o best.csv --method " +
                                     method);
    ASSERT_TRUE(found.contains("parameters"));
    EXPECT_NEAR(found["parameters"]["x"]["value"], 13.0 / 30.0, 0.01);
    EXPECT_NEAR(found["parameters"]["y"]["value"], 17.0 / 30.0, 0.01);
    EXPECT_EQ(found["parameters"]["mode"]["value"], "dry");
    EXPECT_NEAR(found["predicted"][0]["predicted"], 13.0, 0.1);
    EXPECT_EQ(found["predicted"][1]["target"], 21.5);
    EXPECT_LT(found["value"], 1e-4);
    EXPECT_EQ(found["values"].size(), 3u);
  }
}

TEST(OptimiseCommand, MinimisesOrMaximisesOneResponseUnderConstraints) {
  const Workbench bench;
  fit_plane(bench);
  bench.write("factors.toml",
              "[parameters]\nx = { lower = 0.1, upper = 0.9 }\ny = { lower = 0.1, upper = 0.9 }\n"
              "[constraints]\nsum = { coefficients = { x = 1, y = 2 }, upper = 1.5 }\n");
  const std::string rest = " --repeat 2 --evaluations 3000";
  const json low = said_json(bench, "optimise a.h5 --factors factors.toml" + rest);
  EXPECT_NEAR(low["parameters"]["x"]["value"], 0.1, 1e-3);
  EXPECT_NEAR(low["parameters"]["y"]["value"], 0.1, 1e-3);
  const json high = said_json(bench, "optimise b.h5 --maximise --factors factors.toml" + rest);
  EXPECT_NEAR(high["value"], 20.0 + 9.0 - 0.5, 0.05);
  const json edge = said_json(bench, "optimise a.h5 --maximise --factors factors.toml" + rest);
  EXPECT_NEAR(edge["parameters"]["x"]["value"], 0.9, 0.01);  // x + y is largest at (0.9, 0.3)
  EXPECT_NEAR(edge["parameters"]["y"]["value"], 0.3, 0.01);
}

TEST(SampleCommand, ProposesABatchThatFitAndSampleCanGoOnFrom) {
  const Workbench bench;
  fit_plane(bench);
  const std::string sample =
      "sample a.h5 b.h5 --target a=10+-0.1 --target b=22.5 --batch 3 --seed 4 ";
  const json first = said_json(bench, sample + "-o next.csv");
  ASSERT_EQ(first["points"].size(), 3u);
  EXPECT_EQ(first["known_points"], 24);
  EXPECT_NEAR(first["points"][0]["x"], 0.5, 0.05);  // 10 (x + y) = 10, 20 + 10 x - 5 y = 22.5
  EXPECT_NEAR(first["points"][0]["y"], 0.5, 0.05);
  EXPECT_TRUE(first["points"][0].contains("a_predicted"));
  EXPECT_TRUE(first["points"][0].contains("expected_improvement"));
  const json same = said_json(bench, sample + "-o again.csv");
  EXPECT_EQ(first["points"], same["points"]);
  const json other = said_json(bench, sample + "--pending next.csv -o more.csv");
  for (const auto& p : other["points"])
    for (const auto& q : first["points"])
      EXPECT_GT(std::max(std::abs(double(p["x"]) - double(q["x"])),
                         std::abs(double(p["y"]) - double(q["y"]))),
                8e-4);  // 1e-3 of ranges of 0.9
}

TEST(SampleCommand, KnowsEveryAcquisitionBeliefAndRepeat) {
  const Workbench bench;
  bench.write("plane.csv", plane(24));
  ASSERT_EQ(bench.run("repose", "fit plane.csv --input x,y,mode --response a -o a.h5").code, 0);
  const json plain = said_json(bench, "sample a.h5 --batch 2 -o next.h5");
  for (const std::string option :
       {"--acquisition ei", "--acquisition log-ei", "--acquisition nei",
        "--acquisition lcb --kappa 1", "--belief best-lie", "--belief mean-lie",
        "--belief worst-lie", "--repeats allow", "--repeats deliberate", "--maximise"}) {
    const json said = said_json(bench, "sample a.h5 --batch 2 -o next.h5 " + option);
    EXPECT_EQ(said["points"].size(), 2u) << option;
    EXPECT_TRUE(said["points"][0]["mode"].is_string()) << option;
    const bool same_name = option == "--acquisition ei" || option == "--acquisition log-ei";
    const bool first_only = option.starts_with("--belief") || option.starts_with("--repeats");
    EXPECT_EQ(said["points"][0] == plain["points"][0], same_name || first_only) << option;
    if (option.starts_with("--belief")) {
      EXPECT_NE(said["points"], plain["points"]) << option;
    }
  }
}

TEST(SampleCommand, KeepsAwayFromFailedPoints) {
  const Workbench bench;
  fit_plane(bench);
  const json best = said_json(bench, "sample a.h5 --maximise -o next.csv");
  const json moved = said_json(bench, "sample a.h5 --maximise --failed next.csv -o other.csv");
  EXPECT_GE(std::max(std::abs(double(best["points"][0]["x"]) - double(moved["points"][0]["x"])),
                     std::abs(double(best["points"][0]["y"]) - double(moved["points"][0]["y"]))),
            0.085);  // 0.1 of a range of 0.9
}

TEST(SampleAndOptimiseCommands, SayWhatIsWrong) {
  const Workbench bench;
  fit_plane(bench);
  const auto fails = [&](const std::string& command, int code, const std::string& word) {
    const auto said = bench.run("repose", command);
    EXPECT_EQ(said.code, code) << command << said.err;
    EXPECT_NE(said.err.find(word), std::string::npos) << said.err;
  };
  fails("optimise a.h5 b.h5", 3, "--target");
  fails("optimise a.h5 b.h5 --target a=1", 3, "the model of b has no target");
  fails("optimise a.h5 --target c=1", 3, "no model predicts it");
  fails("optimise a.h5 --target a=x", 3, "KPI=VALUE");
  fails("optimise a.h5 --target a=1+-y", 3, "KPI=VALUE");
  fails("optimise a.h5 --target a=1 --weight a=-2", 3, "weight");
  fails("optimise a.h5 --target a=1 --maximise", 3, "--maximise");
  fails("optimise a.h5 --fix z=1", 3, "no such parameter");
  fails("optimise a.h5 --fix x=0.5 --fix y=0.5", 3, "every parameter is fixed");
  fails("optimise a.h5 --fix x=50", 3, "it lies in");
  fails("optimise a.h5 --target a=1 --target a=2", 3, "given twice");
  fails("optimise a.h5 --target a=0", 3, "scale of its own");
  fails("optimise a.h5 --population 50", 3, "--population has no meaning");
  fails("sample a.h5 --kappa 3 -o n.h5", 3, "--kappa has no meaning");
  fails("optimise a.h5 a.h5", 3, "both predict a");
  fails("optimise missing.h5", 6, "missing.h5");
  fails("sample a.h5 --acquisition composite-ei -o n.h5", 3, "--target");
  fails("sample a.h5 --acquisition best -o n.h5", 2, "best");
  fails("sample a.h5 --batch 0 -o n.h5", 2, "--batch");
  fails("sample a.h5 --repeats deliberate --acquisition lcb -o n.h5", 3, "repeats");
  bench.write("factors.toml", "[parameters]\nx = { lower = 0.1, upper = 0.9 }\n");
  fails("sample a.h5 --factors factors.toml -o n.h5", 3, "y, which is no parameter");
  bench.write("more.toml",
              "[parameters]\nx = { lower = 0.1, upper = 0.9 }\ny = { lower = 0, upper = 1 }\n"
              "z = { lower = 0, upper = 1 }\n");
  fails("sample a.h5 --factors more.toml -o n.h5", 3, "no model depends on z");
  EXPECT_FALSE(std::filesystem::exists(bench / "n.h5"));
}

TEST(FitCommand, TunesAsABlackBoxForComparison) {
  const Workbench bench;
  bench.write("plane.csv", plane(24));
  const auto said = bench.run(
      "repose", "fit plane.csv --input x,y --response b --optimise 6 --quiet --json -o m.h5");
  ASSERT_EQ(said.code, 0) << said.err;
  const json fit = json::parse(said.out);
  EXPECT_EQ(fit.at("trials").size(), 6u);
  EXPECT_EQ(bench.run("repose", "fit plane.csv --response b --optimise 6 --select -o m.h5").code,
            3);
}

}  // namespace
}  // namespace repose::test
