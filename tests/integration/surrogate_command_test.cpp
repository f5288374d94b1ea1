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
  EXPECT_EQ(read.at("version"), 2);
  EXPECT_EQ(read.at("names"), fit.at("inputs"));
  EXPECT_EQ(read.at("points"), 36);
  EXPECT_EQ(read.at("factor"), 36 * 37 / 2);
}

}  // namespace
}  // namespace repose::test
