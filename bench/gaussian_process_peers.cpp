// The Gaussian process as a server on stdin and stdout, for bench/gaussian_process_peers.py.
//
// One JSON request a line, one JSON answer a line, {"error": ...} where a request fails:
//   {"op": "fit", "x": [[...], ...], "y": [...], "lower": [...], "upper": [...], ...}
//       optional: kernel, basis, estimator, prior, noise, starts (default: those of the library),
//       select (choose kernel and basis by what is left out), show_starts
//   {"op": "given", ... , "length_scales": [...], "process_variance": v, "noise_variance": v,
//       "alpha": a}                the same at given hyper-parameters
//   {"op": "points", "x": [[...], ...]}   where to predict
//   {"op": "predict", "values": true}     of the last model at the last points
//   {"op": "ei", "mean": m, "sd": s, "best": b}
// Times are of the call alone; JSON is read and written outside of them.
#include <chrono>
#include <cmath>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "repose/base/error.hpp"
#include "repose/opt/acquisition.hpp"
#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/selection.hpp"

namespace {

using namespace repose;
using namespace repose::surrogate;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

Vector vector_of(const json& values) {
  const auto v = values.get<std::vector<double>>();
  return Eigen::Map<const Vector>(v.data(), static_cast<Eigen::Index>(v.size()));
}

Matrix matrix_of(const json& rows) {
  Matrix m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.at(0).size()));
  for (Eigen::Index i = 0; i < m.rows(); ++i) m.row(i) = vector_of(rows[static_cast<size_t>(i)]);
  return m;
}

json json_of(const Vector& v) {
  return std::vector<double>(v.begin(), v.end());
}

template <class Value>
Value value_named(const json& request, const char* key, Value missing,
                  std::initializer_list<Value> values) {
  if (!request.contains(key)) return missing;
  const std::string name = request[key];
  for (const Value v : values)
    if (name == to_string(v)) return v;
  throw InputError(std::string(key) + " '" + name + "' is unknown");
}

GaussianProcessOptions options_of(const json& request) {
  GaussianProcessOptions options;
  if (request.contains("kernel")) options.kernel = kernel_named(std::string(request["kernel"]));
  if (request.contains("basis")) options.basis = basis_named(std::string(request["basis"]));
  options.noise =
      value_named(request, "noise", options.noise, {Noise::none, Noise::estimated, Noise::known});
  options.estimator = value_named(request, "estimator", options.estimator,
                                  {Estimator::ml, Estimator::reml, Estimator::loo});
  if (request.value("prior", "jointly-robust") == "none") options.prior = Prior::none;
  options.parameter_uncertainty =
      value_named(request, "parameter_uncertainty", options.parameter_uncertainty,
                  {ParameterUncertainty::ignored, ParameterUncertainty::first_order});
  options.starts = request.value("starts", options.starts);
  return options;
}

/// Keeps where every search began (log parameters).
struct StartRecorder {
  opt::Minimizer minimizer;
  json* starts;
  opt::Minimum minimize(const opt::Objective& f, const Vector& x, const opt::Bounds& b) const {
    starts->push_back(json_of(x));
    return minimizer.minimize(f, x, b);
  }
};

json describe(const GaussianProcess& model) {
  const Hyperparameters h = model.hyperparameters();
  return {{"length_scales", json_of(h.length_scales)},
          {"process_variance", h.process_variance},
          {"noise_variance", model.noise() == Noise::none ? 0.0 : h.noise_variance},
          {"alpha", h.alpha},
          {"coefficients", json_of(model.coefficients())},
          {"negative_log_likelihood", model.negative_log_likelihood()},
          {"kernel", to_string(model.kernel())},
          {"basis", to_string(model.basis())},
          {"evaluations", model.report().evaluations},
          {"termination", to_string(model.report().termination)},
          {"jitter", model.report().jitter}};
}

class Server {
 public:
  json answer(const json& request) {
    const std::string op = request.at("op");
    if (op == "fit") return fit(request);
    if (op == "given") return given(request);
    if (op == "points") {
      points_ = matrix_of(request.at("x"));
      return json::object();
    }
    if (op == "predict") return predict(request.value("values", false));
    if (op == "ei")
      return {{"value",
               opt::expected_improvement(Gaussian{request.at("mean"), square(request.at("sd"))},
                                         request.at("best"))}};
    throw InputError("op '" + op + "' is unknown");
  }

 private:
  static double square(double x) { return x * x; }

  json fit(const json& request) {
    const Matrix x = matrix_of(request.at("x"));
    const Vector y = vector_of(request.at("y"));
    const opt::Bounds declared{vector_of(request.at("lower")), vector_of(request.at("upper"))};
    GaussianProcessOptions options = options_of(request);
    json starts = json::array();
    if (request.value("show_starts", false))
      options.minimizer = StartRecorder{options.minimizer, &starts};
    const bool select = request.value("select", false);
    const Clock::time_point begin = Clock::now();
    if (select)
      model_ = select_model(x, y, linear_inputs(declared), options).model;
    else
      model_ = GaussianProcess::fit(x, y, declared, options);
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    json result = describe(*model_);
    result["seconds"] = seconds;
    result["starts"] = starts;
    return result;
  }

  json given(const json& request) {
    Hyperparameters h{vector_of(request.at("length_scales")), request.at("process_variance"),
                      request.at("noise_variance")};
    h.alpha = request.value("alpha", 1.0);
    model_ = GaussianProcess::with_parameters(
        matrix_of(request.at("x")), vector_of(request.at("y")),
        opt::Bounds{vector_of(request.at("lower")), vector_of(request.at("upper"))}, h,
        options_of(request));
    return describe(*model_);
  }

  json predict(bool with_values) const {
    const Clock::time_point begin = Clock::now();
    const std::vector<Gaussian> predicted = model_.value().predict_rows(points_);
    json result = {{"seconds", std::chrono::duration<double>(Clock::now() - begin).count()}};
    if (!with_values) return result;
    json& mean = result["mean"] = json::array();
    json& sd = result["sd"] = json::array();
    json& observation_sd = result["observation_sd"] = json::array();
    for (const Prediction& p : model_->predictions(points_)) {
      mean.push_back(p.function.mean);
      sd.push_back(p.function.standard_deviation());
      observation_sd.push_back(std::sqrt(p.observation_variance));
    }
    return result;
  }

  std::optional<GaussianProcess> model_;
  Matrix points_;
};

}  // namespace

int main() {
  Server server;
  std::string line;
  while (std::getline(std::cin, line)) {
    json answer;
    try {
      answer = server.answer(json::parse(line));
    } catch (const std::exception& error) {
      answer = {{"error", error.what()}};
    }
    std::cout << answer.dump() << std::endl;
  }
}
