// The state of a Bayesian optimisation on disk.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/opt/bayesian_optimizer.hpp"
#include "repose/table/io.hpp"

namespace repose::opt {
namespace {

using table::Attributes;
using table::Table;

constexpr const char* kState = "bayesian-optimization";
constexpr std::int64_t kVersion = 1;
constexpr std::array kKinds{"continuous", "integer", "levels", "categorical"};
constexpr std::array kStates{TrialState::pending, TrialState::done, TrialState::failed};
constexpr std::array kAcquisitions{Acquisition::expected_improvement,
                                   Acquisition::noisy_expected_improvement,
                                   Acquisition::lower_confidence_bound};
constexpr std::array kBeliefs{Belief::kriging, Belief::best_lie, Belief::mean_lie,
                              Belief::worst_lie};
constexpr std::array kPenalties{Penalty::absolute, Penalty::squared};
constexpr std::array kRepeats{Repeats::avoid, Repeats::allow, Repeats::deliberate};

using Doubles = std::vector<double>;
using Texts = std::vector<std::string>;
using Integers = std::vector<std::int64_t>;

void add(Table& table, std::string name, table::Values values) {
  table.add({.name = std::move(name), .values = std::move(values)});
}

/// Names of parameters and responses may be alike, or like those of other columns.
std::string parameter_column(const std::string& parameter) {
  return "parameter:" + parameter;
}
std::string response_column(const std::string& response) {
  return "response:" + response;
}

/// Bits of a seed as a signed number, as files have no others.
std::int64_t as_signed(std::uint64_t seed) {
  return static_cast<std::int64_t>(seed);
}

Attributes attributes_of(const BayesianOptimizationOptions& o, std::int64_t initial_asked) {
  const ProposeOptions& p = o.propose;
  return {{"repose_state", std::string(kState)},
          {"state_version", kVersion},
          {"seed", as_signed(o.seed)},
          {"initial_points", std::int64_t{o.initial_points}},
          {"initial_asked", initial_asked},
          {"acquisition", std::string(to_string(p.acquisition))},
          {"kappa", p.kappa},
          {"belief", std::string(to_string(p.belief))},
          {"repeats", std::string(to_string(p.repeats))},
          {"failed_distance", p.failed_distance},
          {"minimum_distance", p.minimum_distance},
          {"candidates", std::int64_t{p.candidates}},
          {"polished", std::int64_t{p.polished}},
          {"polish_evaluations", std::int64_t{p.polish_evaluations}},
          {"draws", std::int64_t{p.draws}}};
}

Table parameters_table(const ParameterSpace& space) {
  Texts name, unit, scale, kind;
  Doubles lower, upper;
  for (const Parameter& p : space.parameters()) {
    name.push_back(p.name);
    unit.push_back(p.unit);
    scale.emplace_back(p.scale == Scale::log ? "log" : "linear");
    kind.emplace_back(kKinds[static_cast<std::size_t>(p.kind)]);
    lower.push_back(p.lower);
    upper.push_back(p.upper);
  }
  Table t;
  add(t, "name", name);
  add(t, "lower", lower);
  add(t, "upper", upper);
  add(t, "scale", scale);
  add(t, "unit", unit);
  add(t, "kind", kind);
  return t;
}

/// Levels and categories, one after another: the value of a level, the name of a category.
Table levels_table(const ParameterSpace& space) {
  Texts parameter, name;
  Doubles value;
  for (const Parameter& p : space.parameters()) {
    for (const double level : p.levels) {
      parameter.push_back(p.name);
      value.push_back(level);
      name.emplace_back("");
    }
    for (std::size_t i = 0; i < p.categories.size(); ++i) {
      parameter.push_back(p.name);
      value.push_back(static_cast<double>(i));
      name.push_back(p.categories[i]);
    }
  }
  Table t;
  add(t, "parameter", parameter);
  add(t, "value", value);
  add(t, "name", name);
  return t;
}

Table fixed_table(const ParameterSpace& space) {
  Texts name;
  Doubles value;
  for (const auto& [n, v] : space.fixed()) {
    name.push_back(n);
    value.push_back(v);
  }
  Table t;
  add(t, "name", name);
  add(t, "value", value);
  return t;
}

Table ties_table(const ParameterSpace& space) {
  Texts name, source;
  for (const Tie& tie : space.ties())
    for (const std::string& s : tie.sources) {
      name.push_back(tie.name);
      source.push_back(s);
    }
  Table t;
  add(t, "name", name);
  add(t, "source", source);
  return t;
}

/// A row a term; an end that is open is the largest number.
Table constraints_table(const ParameterSpace& space) {
  Integers constraint;  // names may be alike
  Texts name, parameter;
  Doubles coefficient, lower, upper;
  constexpr double kLargest = std::numeric_limits<double>::max();
  std::int64_t number = 0;
  for (const LinearConstraint& c : space.constraints()) {
    ++number;
    for (const auto& [p, value] : c.coefficients) {
      constraint.push_back(number);
      name.push_back(c.name);
      parameter.push_back(p);
      coefficient.push_back(value);
      lower.push_back(std::max(c.lower, -kLargest));
      upper.push_back(std::min(c.upper, kLargest));
    }
  }
  Table t;
  add(t, "constraint", constraint);
  add(t, "name", name);
  add(t, "parameter", parameter);
  add(t, "coefficient", coefficient);
  add(t, "lower", lower);
  add(t, "upper", upper);
  return t;
}

Table responses_table(const OptimizationProblem& problem) {
  Doubles value, weight, scale, deviation;
  Texts penalty;
  for (const Target& t : problem.targets) {
    penalty.emplace_back(to_string(t.penalty));
    value.push_back(t.value);
    weight.push_back(t.weight);
    scale.push_back(t.scale);
    deviation.push_back(t.standard_deviation);
  }
  Table t;
  add(t, "name", problem.responses);
  if (problem.targets.empty()) return t;
  add(t, "target", value);
  add(t, "weight", weight);
  add(t, "scale", scale);
  add(t, "standard_deviation", deviation);
  add(t, "penalty", penalty);
  return t;
}

Table trials_table(const OptimizationProblem& problem, const std::vector<Trial>& trials) {
  Integers id;
  Texts state;
  Doubles merit;
  for (const Trial& trial : trials) {
    id.push_back(trial.id);
    state.emplace_back(to_string(trial.state));
    merit.push_back(std::isinf(trial.merit) ? std::copysign(1e308, trial.merit) : trial.merit);
  }
  Table t;
  add(t, "trial", id);
  add(t, "state", state);
  add(t, "merit", merit);
  for (std::size_t k = 0; k < problem.parameters.dimension(); ++k) {
    Doubles values;
    for (const Trial& trial : trials) values.push_back(trial.x[static_cast<Eigen::Index>(k)]);
    add(t, parameter_column(problem.parameters.parameters()[k].name), values);
  }
  for (std::size_t j = 0; j < problem.responses.size(); ++j) {
    Doubles values;
    for (const Trial& trial : trials)
      values.push_back(trial.state == TrialState::done ? trial.y[static_cast<Eigen::Index>(j)]
                                                       : std::numeric_limits<double>::quiet_NaN());
    add(t, response_column(problem.responses[j]), values);
  }
  return t;
}

/// A state file whose every inconsistency is a StorageError that names the file.
class Reader {
 public:
  explicit Reader(std::filesystem::path path)
      : path_(std::move(path)), attributes_(table::read_attributes({path_, "/"})) {
    const auto kind = attributes_.find("repose_state");
    if (kind == attributes_.end() || kind->second != table::Attribute(std::string(kState)))
      throw StorageError(fmt::format("'{}' is not the state of an optimisation", path_.string()));
    const auto version = get<std::int64_t>("state_version");
    if (version < 1 || version > kVersion)
      throw StorageError(
          fmt::format("'{}' has state version {}; this program reads up to {}: use a newer one",
                      path_.string(), version, kVersion));
  }

  [[noreturn]] void damaged(const std::string& what) const {
    throw StorageError(fmt::format("state file '{}' is damaged: {}", path_.string(), what));
  }

  template <class T>
  T get(const std::string& name) const {
    const auto found = attributes_.find(name);
    if (found == attributes_.end()) damaged(fmt::format("attribute '{}' is missing", name));
    const T* value = std::get_if<T>(&found->second);
    if (value == nullptr) damaged(fmt::format("attribute '{}' has the wrong type", name));
    return *value;
  }
  int count(const std::string& name) const {
    const auto value = get<std::int64_t>(name);
    if (value < 0 || value > std::numeric_limits<int>::max())
      damaged(fmt::format("attribute '{}' is {}", name, value));
    return static_cast<int>(value);
  }
  template <class Enum, std::size_t N>
  Enum choice(const std::string& text, const std::array<Enum, N>& values) const {
    for (const Enum value : values)
      if (text == to_string(value)) return value;
    damaged(fmt::format("'{}' is not known to this version", text));
  }
  Table read(const std::string& group) const {
    return table::read_table({path_, group}, table::Missing::allow);
  }
  Table read_if_there(const std::string& group) const {
    const auto groups = table::list_tables(path_);
    return std::find(groups.begin(), groups.end(), group) == groups.end() ? Table{} : read(group);
  }

  BayesianOptimizationOptions options() const {
    BayesianOptimizationOptions o{.initial_points = count("initial_points"),
                                  .seed = static_cast<std::uint64_t>(get<std::int64_t>("seed"))};
    ProposeOptions& p = o.propose;
    p.acquisition = choice(get<std::string>("acquisition"), kAcquisitions);
    p.kappa = get<double>("kappa");
    p.belief = choice(get<std::string>("belief"), kBeliefs);
    p.repeats = choice(get<std::string>("repeats"), kRepeats);
    p.failed_distance = get<double>("failed_distance");
    p.minimum_distance = get<double>("minimum_distance");
    p.candidates = count("candidates");
    p.polished = count("polished");
    p.polish_evaluations = count("polish_evaluations");
    p.draws = count("draws");
    return o;
  }

  ParameterSpace parameters() const {
    const Table t = read("/parameters");
    std::vector<Parameter> free;
    for (std::size_t k = 0; k < t.rows(); ++k) {
      const std::string& kind = t.texts("kind")[k];
      const auto found = std::find(kKinds.begin(), kKinds.end(), kind);
      if (found == kKinds.end()) damaged(fmt::format("kind '{}' is not known", kind));
      free.push_back({.name = t.texts("name")[k],
                      .lower = t.numbers("lower")[k],
                      .upper = t.numbers("upper")[k],
                      .scale = t.texts("scale")[k] == "log" ? Scale::log : Scale::linear,
                      .unit = t.texts("unit")[k],
                      .kind = static_cast<ParameterKind>(found - kKinds.begin())});
    }
    const Table levels = read_if_there("/levels");
    for (std::size_t i = 0; i < levels.rows(); ++i)
      for (Parameter& p : free) {
        if (p.name != levels.texts("parameter")[i]) continue;
        if (p.kind == ParameterKind::levels) p.levels.push_back(levels.numbers("value")[i]);
        if (p.kind == ParameterKind::categorical) p.categories.push_back(levels.texts("name")[i]);
      }
    return ParameterSpace(std::move(free), fixed(), ties(), constraints());
  }

  OptimizationProblem problem() const {
    const Table t = read("/responses");
    OptimizationProblem problem{.parameters = parameters(), .responses = t.texts("name")};
    if (!t.has("target")) return problem;
    for (std::size_t j = 0; j < t.rows(); ++j)
      problem.targets.push_back({.name = problem.responses[j],
                                 .value = t.numbers("target")[j],
                                 .weight = t.numbers("weight")[j],
                                 .scale = t.numbers("scale")[j],
                                 .standard_deviation = t.numbers("standard_deviation")[j],
                                 .penalty = choice(t.texts("penalty")[j], kPenalties)});
    return problem;
  }

  std::vector<Trial> trials(const OptimizationProblem& problem) const {
    const Table t = read_if_there("/trials");
    std::vector<Trial> all;
    if (t.rows() == 0) return all;
    Texts columns;
    for (const std::string& name : problem.parameters.names())
      columns.push_back(parameter_column(name));
    const Matrix x = t.matrix(columns);
    columns.clear();
    for (const std::string& response : problem.responses)
      columns.push_back(response_column(response));
    const Matrix y = t.matrix(columns);
    const auto merit = t.numbers("merit");
    if (!x.allFinite()) damaged("a trial has no place");
    for (std::size_t i = 0; i < t.rows(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      Trial trial{.id = static_cast<std::int64_t>(i) + 1,
                  .x = x.row(row),
                  .state = choice(t.texts("state")[i], kStates),
                  .merit = std::abs(merit[i]) >= 1e308
                               ? std::copysign(std::numeric_limits<double>::infinity(), merit[i])
                               : merit[i]};
      if (trial.state == TrialState::done) {
        trial.y = y.row(row);
        if (!trial.y.allFinite()) damaged(fmt::format("trial {} is done without a result", i + 1));
      }
      all.push_back(std::move(trial));
    }
    return all;
  }

 private:
  ParameterValues fixed() const {
    const Table t = read_if_there("/fixed");
    ParameterValues values;
    for (std::size_t i = 0; i < t.rows(); ++i) values[t.texts("name")[i]] = t.numbers("value")[i];
    return values;
  }
  std::vector<Tie> ties() const {
    const Table t = read_if_there("/ties");
    std::vector<Tie> all;
    for (std::size_t i = 0; i < t.rows(); ++i) {
      if (all.empty() || all.back().name != t.texts("name")[i])
        all.push_back({.name = t.texts("name")[i]});
      all.back().sources.push_back(t.texts("source")[i]);
    }
    return all;
  }
  std::vector<LinearConstraint> constraints() const {
    const Table t = read_if_there("/constraints");
    std::vector<LinearConstraint> all;
    constexpr double kLargest = std::numeric_limits<double>::max();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < t.rows(); ++i) {
      const double lower = t.numbers("lower")[i];
      const double upper = t.numbers("upper")[i];
      if (static_cast<std::int64_t>(all.size()) < t.integers("constraint")[i])
        all.push_back({.name = t.texts("name")[i],
                       .lower = lower <= -kLargest ? -kInfinity : lower,
                       .upper = upper >= kLargest ? kInfinity : upper});
      all.back().coefficients[t.texts("parameter")[i]] = t.numbers("coefficient")[i];
    }
    return all;
  }

  std::filesystem::path path_;
  Attributes attributes_;
};

}  // namespace

void BayesianOptimizer::save(const std::filesystem::path& path) const {
  std::vector<std::pair<std::string, Table>> tables{
      {"/parameters", parameters_table(problem_.parameters)},
      {"/responses", responses_table(problem_)}};
  const auto add_if_any = [&tables](const char* name, Table t) {
    if (t.rows() > 0) tables.emplace_back(name, std::move(t));
  };
  add_if_any("/levels", levels_table(problem_.parameters));
  add_if_any("/fixed", fixed_table(problem_.parameters));
  add_if_any("/ties", ties_table(problem_.parameters));
  add_if_any("/constraints", constraints_table(problem_.parameters));
  add_if_any("/trials", trials_table(problem_, trials_));
  table::write_tables(path, tables, attributes_of(options_, initial_asked_));
}

BayesianOptimizer BayesianOptimizer::load(const std::filesystem::path& path,
                                          SurrogateFitter fitter) {
  const Reader reader(path);
  try {
    BayesianOptimizer optimizer(reader.problem(), std::move(fitter), reader.options());
    optimizer.trials_ = reader.trials(optimizer.problem_);
    optimizer.initial_asked_ = reader.count("initial_asked");
    return optimizer;
  } catch (const InputError& error) {
    reader.damaged(error.what());
  }
}

}  // namespace repose::opt
