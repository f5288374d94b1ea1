#include "model_set.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "design_columns.hpp"
#include "design_table.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

using surrogate::NamedModel;

std::vector<NamedModel> loaded(const std::vector<std::string>& files) {
  std::vector<NamedModel> models;
  for (const auto& file : files) {
    models.push_back(surrogate::load_model(file));
    for (std::size_t i = 0; i + 1 < models.size(); ++i)
      if (models[i].response == models.back().response)
        throw InputError(
            fmt::format("{} and {} both predict {}", files[i], file, models[i].response));
  }
  return models;
}

Parameter parameter_of(const std::string& name, const surrogate::Input& input) {
  Parameter p{.name = name, .lower = input.lower, .upper = input.upper, .scale = input.scale};
  if (input.is_categorical()) {
    p.kind = ParameterKind::categorical;
    p.categories = input.levels;
  }
  return p;
}

/// Every input of the models once, its range what is common to them.
std::vector<Parameter> inputs_of(const std::vector<NamedModel>& models) {
  std::vector<Parameter> all;
  for (const NamedModel& m : models)
    for (std::size_t k = 0; k < m.inputs.size(); ++k) {
      const Parameter p = parameter_of(m.inputs[k], m.model.inputs()[k]);
      const auto found =
          std::find_if(all.begin(), all.end(), [&](const auto& a) { return a.name == p.name; });
      if (found == all.end()) {
        all.push_back(p);
        continue;
      }
      if (found->categories != p.categories)
        throw InputError(fmt::format("the models know other names of {}: {} and {}", p.name,
                                     fmt::join(found->categories, ", "),
                                     fmt::join(p.categories, ", ")));
      found->lower = std::max(found->lower, p.lower);
      found->upper = std::min(found->upper, p.upper);
      if (p.categories.empty() && !(found->lower < found->upper))
        throw InputError(fmt::format(
            "the models of {} have no range in common; give one with --factors", p.name));
    }
  return all;
}

std::optional<double> number_in(std::string_view text) {
  double value = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

struct Assignment {
  std::string name;
  std::string value;
};

Assignment assignment(const std::string& text, const char* option, const char* form) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw InputError(fmt::format("{} {}: write {}", option, text, form));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// KPI=VALUE, or with the standard deviation of its measurement, KPI=VALUE+-SD or KPI=VALUE±SD.
opt::Target target_of(const std::string& text) {
  constexpr const char* kForm = "KPI=VALUE or KPI=VALUE+-SD, e.g. angle_deg=38.2+-0.5";
  const auto [name, value] = assignment(text, "--target", kForm);
  opt::Target target{.name = name};
  std::string number = value;
  for (const std::string_view sign : {"+-", "±"})
    if (const auto at = value.find(sign); at != std::string::npos) {
      number = value.substr(0, at);
      const auto deviation = number_in(std::string_view(value).substr(at + sign.size()));
      if (!deviation) throw InputError(fmt::format("--target {}: write {}", text, kForm));
      target.standard_deviation = *deviation;
      break;
    }
  const auto read = number_in(number);
  if (!read) throw InputError(fmt::format("--target {}: write {}", text, kForm));
  target.value = *read;
  return target;
}

constexpr const char* kOfTarget = "KPI=NUMBER with the KPI of a --target";

double number_of(const char* option, const std::string& text) {
  const auto value = number_in(assignment(text, option, kOfTarget).value);
  if (!value) throw InputError(fmt::format("{} {}: write {}", option, text, kOfTarget));
  return *value;
}

opt::Target& target_named(std::vector<opt::Target>& targets, const char* option,
                          const std::string& text) {
  const std::string name = assignment(text, option, kOfTarget).name;
  const auto found =
      std::find_if(targets.begin(), targets.end(), [&](const auto& t) { return t.name == name; });
  if (found == targets.end())
    throw InputError(fmt::format("{} {}: write {}", option, text, kOfTarget));
  return *found;
}

double value_to_fix(const Parameter* p, const Assignment& fix) {
  if (p != nullptr && p->kind == ParameterKind::categorical) {
    const auto found = std::find(p->categories.begin(), p->categories.end(), fix.value);
    if (found == p->categories.end())
      throw InputError(fmt::format("--fix {}={}: the names are {}", fix.name, fix.value,
                                   fmt::join(p->categories, ", ")));
    return static_cast<double>(found - p->categories.begin());
  }
  const auto value = number_in(fix.value);
  if (!value)
    throw InputError(fmt::format("--fix {}={}: the value must be a number", fix.name, fix.value));
  if (p == nullptr) return *value;
  if (*value < p->lower || *value > p->upper)
    throw InputError(
        fmt::format("--fix {}={}: it lies in [{}, {}]; give other ranges with "
                    "--factors",
                    fix.name, fix.value, shortest(p->lower), shortest(p->upper)));
  const double nearest = natural_value(*p, unit_value(*p, *value));
  if (level_count(*p) > 0 && nearest != *value)
    throw InputError(fmt::format("--fix {}={}: the nearest value it takes is {}", fix.name,
                                 fix.value, shortest(nearest)));
  return *value;
}

/// Minus a surrogate.
struct Negated {
  opt::Surrogate inner;
  static Gaussian minus(Gaussian g) {
    g.mean = -g.mean;
    return g;
  }
  Gaussian predict(const Vector& x) const { return minus(inner.predict(x)); }
  std::vector<Gaussian> predict_rows(const Matrix& rows) const {
    auto all = inner.predict_rows(rows);
    for (Gaussian& g : all) g = minus(g);
    return all;
  }
  Negated condition_on(const Vector& x, double y) const { return {inner.condition_on(x, -y)}; }
  bool has_gradient() const { return inner.has_gradient(); }
  opt::PredictionGradient predict_gradient(const Vector& x) const {
    auto g = inner.predict_gradient(x);
    g.function = minus(g.function);
    g.mean = -g.mean;
    return g;
  }
  bool has_covariance() const { return inner.has_covariance(); }
  Matrix covariance(const Matrix& a, const Matrix& b) const { return inner.covariance(a, b); }
};

}  // namespace

/// From natural values of the free parameters to the inputs of one model: affine where they are
/// numbers, the place of a name where they are categories.
struct ModelSet::Mapping {
  Matrix slope;  ///< inputs x free parameters
  Vector offset;
  struct Category {
    Eigen::Index input;
    Eigen::Index parameter;      ///< -1: fixed, its place in `offset`
    std::vector<double> places;  ///< of the parameter's names among the model's
  };
  std::vector<Category> categories;

  bool uses(Eigen::Index parameter) const {
    return (slope.col(parameter).array() != 0.0).any() ||
           std::any_of(categories.begin(), categories.end(),
                       [parameter](const Category& c) { return c.parameter == parameter; });
  }
  Vector inputs(const Vector& natural) const {
    Vector x = slope * natural + offset;
    for (const Category& c : categories)
      if (c.parameter >= 0) x[c.input] = c.places[static_cast<std::size_t>(natural[c.parameter])];
    return x;
  }
  Mapping(const NamedModel& model, const ParameterSpace& space, const std::vector<Parameter>& named)
      : slope(Matrix::Zero(model.model.dimension(), static_cast<Eigen::Index>(space.dimension()))),
        offset(model.model.dimension()) {
    const auto d = static_cast<Eigen::Index>(space.dimension());
    const ParameterValues origin = space.complete(Vector::Zero(d));
    const auto names = space.names();
    for (std::size_t k = 0; k < model.inputs.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const std::string& name = model.inputs[k];
      if (!origin.contains(name))
        throw InputError(
            fmt::format("the model of {} has the input {}, which is no parameter; "
                        "there are {}",
                        model.response, name, fmt::join(names, ", ")));
      offset[row] = origin.at(name);
      if (model.model.inputs()[k].is_categorical()) {
        add_category(model, k, named, names);
        continue;
      }
      for (const Parameter& p : named)
        if (p.name == name && p.kind == ParameterKind::categorical)
          throw InputError(
              fmt::format("the model of {} takes {} for a number; the factors file "
                          "gives it names",
                          model.response, name));
      for (Eigen::Index p = 0; p < d; ++p) {
        Vector unit = Vector::Zero(d);
        unit[p] = 1.0;
        slope(row, p) = space.complete(unit).at(name) - offset[row];
      }
    }
  }

 private:
  void add_category(const NamedModel& model, std::size_t k, const std::vector<Parameter>& named,
                    const std::vector<std::string>& names) {
    const auto& levels = model.model.inputs()[k].levels;
    const auto p = std::find_if(named.begin(), named.end(),
                                [&](const auto& n) { return n.name == model.inputs[k]; });
    if (p == named.end() || p->kind != ParameterKind::categorical)
      throw InputError(
          fmt::format("the model of {} takes {} for a category with the names {}; the "
                      "factors file does not",
                      model.response, model.inputs[k], fmt::join(levels, ", ")));
    Category category{.input = static_cast<Eigen::Index>(k), .parameter = -1, .places = {}};
    for (const std::string& name : p->categories) {
      const auto found = std::find(levels.begin(), levels.end(), name);
      if (found == levels.end())
        throw InputError(
            fmt::format("{} may be '{}', which the model of {} does not know; it "
                        "knows {}",
                        p->name, name, model.response, fmt::join(levels, ", ")));
      category.places.push_back(static_cast<double>(found - levels.begin()));
    }
    const auto free = std::find(names.begin(), names.end(), model.inputs[k]);
    if (free != names.end())
      category.parameter = free - names.begin();
    else
      offset[category.input] = category.places[static_cast<std::size_t>(offset[category.input])];
    categories.push_back(std::move(category));
  }
};

ParameterSpace ModelSet::parameters_of(const std::vector<NamedModel>& models,
                                       const ModelSetOptions& options,
                                       std::vector<Parameter>& named) {
  const ParameterSpace given =
      options.factors.empty() ? ParameterSpace(inputs_of(models)) : read_factors(options.factors);
  named = given.parameters();
  std::vector<Parameter> free = named;
  ParameterValues fixed = given.fixed();
  for (const std::string& text : options.fixed) {
    const Assignment fix = assignment(text, "--fix", "NAME=VALUE");
    const auto found =
        std::find_if(free.begin(), free.end(), [&](const auto& p) { return p.name == fix.name; });
    if (found == free.end() && !fixed.contains(fix.name))
      throw InputError(fmt::format("--fix {}: no such parameter; there are {}", text,
                                   fmt::join(given.names(), ", ")));
    fixed[fix.name] = value_to_fix(found == free.end() ? nullptr : &*found, fix);
    if (found != free.end()) free.erase(found);
  }
  if (free.empty()) throw InputError("every parameter is fixed; nothing is left to search");
  return ParameterSpace(free, fixed, given.ties(), given.constraints());
}

void ModelSet::read_targets(const ModelSetOptions& options) {
  std::vector<opt::Target> given;
  for (const std::string& text : options.targets) given.push_back(target_of(text));
  const auto responses = [&] {
    std::vector<std::string> names;
    for (const auto& m : models_) names.push_back(m.response);
    return names;
  }();
  for (std::size_t i = 0; i < given.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (given[i].name == given[j].name)
        throw InputError(fmt::format("--target {} is given twice", given[i].name));
  for (const opt::Target& t : given)
    if (std::count(responses.begin(), responses.end(), t.name) != 1)
      throw InputError(fmt::format("--target {}: no model predicts it; there are models of {}",
                                   t.name, fmt::join(responses, ", ")));
  for (const std::string& text : options.weights)
    target_named(given, "--weight", text).weight = number_of("--weight", text);
  for (const std::string& text : options.scales) {
    const double scale = number_of("--scale", text);
    if (!(scale > 0.0)) throw InputError(fmt::format("--scale {}: it must be above 0", text));
    target_named(given, "--scale", text).scale = scale;
  }
  for (opt::Target& t : given)
    t.penalty = options.loss == "squared" ? opt::Penalty::squared : opt::Penalty::absolute;
  if (given.empty()) {
    if (options.loss == "squared") throw InputError("--loss has no meaning without --target");
    if (models_.size() > 1)
      throw InputError(
          fmt::format("{} models and no target: say what is wanted, e.g. --target {}=VALUE",
                      models_.size(), responses[0]));
    return;
  }
  if (options.maximise) throw InputError("--maximise has no meaning with --target");
  for (const auto& name : responses) {
    const auto found =
        std::find_if(given.begin(), given.end(), [&](const auto& t) { return t.name == name; });
    if (found == given.end())
      throw InputError(
          fmt::format("the model of {} has no target; add --target {}=VALUE or leave the model out",
                      name, name));
    targets_.push_back(*found);
  }
  opt::check_targets(targets_);
}

ModelSet::ModelSet(const ModelSetOptions& options)
    : models_(loaded(options.models)),
      space_(parameters_of(models_, options, named_)),
      maximise_(options.maximise) {
  read_targets(options);
  for (const NamedModel& m : models_) {
    const auto mapping = std::make_shared<const Mapping>(m, space_.parameters(), named_);
    mappings_.push_back(mapping);
    const auto in_natural = opt::mapped_surrogate(
        m.model, [mapping](const Vector& x) { return mapping->inputs(x); },
        [mapping](const Vector&) { return mapping->slope; });
    const auto surrogate = space_.in_coordinates(in_natural);
    surrogates_.push_back(maximise_ ? opt::Surrogate(Negated{surrogate}) : surrogate);
  }
  refuse_unused_parameters();
  if (options.runs.empty())
    add_known_points();
  else
    known_ =
        points_of(table::read_table(table::parse_location(options.runs), table::Missing::allow),
                  options.runs);
}

void ModelSet::refuse_unused_parameters() const {
  const auto& free = space_.parameters().parameters();
  for (std::size_t k = 0; k < free.size(); ++k) {
    bool used = false;
    for (const auto& mapping : mappings_)
      used = used || mapping->uses(static_cast<Eigen::Index>(k));
    if (!used)
      throw InputError(fmt::format("no model depends on {}; give it a value with --fix {}=VALUE",
                                   free[k].name, free[k].name));
  }
}

void ModelSet::refuse_names(std::initializer_list<const char*> reserved) const {
  const auto values = space_.parameters().complete(Vector::Zero(space_.dimension()));
  for (const char* name : reserved)
    if (values.contains(name))
      throw InputError(
          fmt::format("a parameter is called {}, as a column of the result is; rename "
                      "it",
                      name));
}

std::optional<Vector> ModelSet::natural_of(std::size_t j, const Vector& inputs) const {
  const NamedModel& m = models_[j];
  const auto names = space_.parameters().names();
  Vector natural(space_.dimension());
  for (std::size_t p = 0; p < names.size(); ++p) {
    const auto found = std::find(m.inputs.begin(), m.inputs.end(), names[p]);
    if (found == m.inputs.end()) return std::nullopt;
    const auto input = static_cast<Eigen::Index>(found - m.inputs.begin());
    double value = inputs[input];
    for (const auto& c : mappings_[j]->categories) {
      if (c.input != input) continue;
      const auto place = std::find(c.places.begin(), c.places.end(), value);
      if (place == c.places.end()) return std::nullopt;
      value = static_cast<double>(place - c.places.begin());
    }
    natural[static_cast<Eigen::Index>(p)] = value;
  }
  const Vector back = mappings_[j]->inputs(natural);
  const opt::Bounds declared = m.model.declared_bounds();
  const Vector range = (declared.upper - declared.lower).cwiseMax(1e-300);
  if ((back - inputs).cwiseQuotient(range).cwiseAbs().maxCoeff() > 1e-9) return std::nullopt;
  return within_ranges(natural) ? std::optional(natural) : std::nullopt;
}

bool ModelSet::within_ranges(const Vector& natural) const {
  const auto& free = space_.parameters().parameters();
  for (std::size_t k = 0; k < free.size(); ++k) {
    const double value = natural[static_cast<Eigen::Index>(k)];
    const double rounding = 1e-9 * (free[k].upper - free[k].lower);
    if (!(value >= free[k].lower - rounding && value <= free[k].upper + rounding)) return false;
  }
  return true;
}

Points ModelSet::points_from(const std::vector<Vector>& rows) const {
  Points points{Matrix(static_cast<Eigen::Index>(rows.size()), space_.dimension()), {}};
  for (std::size_t i = 0; i < rows.size(); ++i)
    points.natural.row(static_cast<Eigen::Index>(i)) = rows[i];
  points.coordinates = space_.coordinates_rows(points.natural);
  return points;
}

void ModelSet::add_known_points() {
  std::vector<Vector> rows;
  for (std::size_t j = 0; j < models_.size(); ++j)
    for (const auto& row : models_[j].model.points().rowwise()) {
      const auto natural = natural_of(j, row.transpose());
      if (natural && std::find(rows.begin(), rows.end(), *natural) == rows.end())
        rows.push_back(*natural);
    }
  known_ = points_from(rows);
}

Points ModelSet::points_of(const table::Table& table, const std::string& file) const {
  const auto& free = space_.parameters().parameters();
  std::vector<Vector> rows(table.rows(), Vector(space_.dimension()));
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (free[k].kind == ParameterKind::categorical) {
      const auto& texts = table.texts(free[k].name);
      const auto& names = free[k].categories;
      for (std::size_t i = 0; i < texts.size(); ++i) {
        const auto found = std::find(names.begin(), names.end(), texts[i]);
        if (found == names.end())
          throw InputError(fmt::format("{}: row {}, {} is '{}'; the names are {}", file, i + 1,
                                       free[k].name, texts[i], fmt::join(names, ", ")));
        rows[i][column] = static_cast<double>(found - names.begin());
      }
      continue;
    }
    const auto values = table.numbers(free[k].name);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!(values[i] >= free[k].lower && values[i] <= free[k].upper))
        throw InputError(fmt::format("{}: row {}, {} is {}; it lies in [{}, {}]", file, i + 1,
                                     free[k].name, shortest(values[i]), shortest(free[k].lower),
                                     shortest(free[k].upper)));
      rows[i][column] = values[i];
    }
  }
  return points_from(rows);
}

Vector ModelSet::objective_means(const Matrix& coordinates) const {
  std::vector<std::vector<Gaussian>> predicted;
  for (const auto& s : surrogates_) predicted.push_back(s.predict_rows(coordinates));
  Vector means(coordinates.rows());
  std::vector<Gaussian> p(surrogates_.size());
  for (Eigen::Index i = 0; i < means.size(); ++i) {
    for (std::size_t j = 0; j < p.size(); ++j) p[j] = predicted[j][static_cast<std::size_t>(i)];
    means[i] = targets_.empty() ? p[0].mean
                                : opt::weighted_error(std::span<const Gaussian>(p), targets_).mean;
  }
  return means;
}

std::string ModelSet::objective_name() const {
  if (targets_.empty()) return models_[0].response;
  std::vector<std::string> names;
  for (const auto& t : targets_) names.push_back(t.name);
  return fmt::format("expected weighted {} of {}",
                     targets_[0].penalty == opt::Penalty::squared ? "squared error" : "error",
                     fmt::join(names, ", "));
}

table::Table ModelSet::runs(const Matrix& natural) const {
  const table::Table all = runs_table(space_.parameters(), natural);
  table::Table runs;
  for (const auto& column : all.columns()) {
    const auto p = std::find_if(named_.begin(), named_.end(),
                                [&](const auto& n) { return n.name == column.name; });
    const bool fixed_name = p != named_.end() && p->kind == ParameterKind::categorical &&
                            space_.parameters().fixed().contains(column.name);
    if (!fixed_name) {
      runs.add(column);
      continue;
    }
    const auto place = static_cast<std::size_t>(space_.parameters().fixed().at(column.name));
    runs.add({.name = column.name,
              .range = {},
              .values = std::vector<std::string>(all.rows(), p->categories[place])});
  }
  for (std::size_t j = 0; j < models_.size(); ++j) {
    Matrix inputs(natural.rows(), models_[j].model.dimension());
    for (Eigen::Index i = 0; i < natural.rows(); ++i)
      inputs.row(i) = mappings_[j]->inputs(natural.row(i));
    std::vector<double> mean, sd;
    std::vector<std::int64_t> doubtful;
    for (const auto& p : models_[j].model.predictions(inputs)) {
      mean.push_back(p.function.mean);
      sd.push_back(p.function.standard_deviation());
      doubtful.push_back(p.far_from_data || p.outside_range ? 1 : 0);
    }
    const std::string& response = models_[j].response;
    runs.add({.name = response + "_predicted", .range = {}, .values = std::move(mean)});
    runs.add({.name = response + "_function_sd", .range = {}, .values = std::move(sd)});
    runs.add({.name = response + "_extrapolated", .range = {}, .values = std::move(doubtful)});
  }
  return runs;
}

void add_model_set_options(CLI::App& command, ModelSetOptions& o) {
  command.add_option("MODEL", o.models, "files written by repose fit, one a response")->required();
  command.add_option("--target", o.targets,
                     "KPI=VALUE, KPI=VALUE+-SD; none: the response is minimised");
  command.add_option("--weight", o.weights, "KPI=WEIGHT in the weighted error; else 1");
  command.add_option("--scale", o.scales, "KPI=SCALE: the error that counts as 1; else the target");
  command.add_option("--loss", o.loss, "of an error over its scale")
      ->capture_default_str()
      ->check(CLI::IsMember({"absolute", "squared"}));
  command.add_flag("--maximise", o.maximise, "the response of the one model");
  command.add_option("--fix", o.fixed, "NAME=VALUE of a parameter that is not searched");
  command.add_option("--factors", o.factors, "TOML file: ranges, ties, constraints");
  command.add_option("--runs", o.runs, "table of the runs done; else the models' points");
}

}  // namespace repose::cli
