#include "repose/surrogate/model_file.hpp"

#include <fmt/format.h>

#include <array>
#include <tuple>

#include "gaussian_process_file.hpp"
#include "model_kinds.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/table/io.hpp"

namespace repose::surrogate {
namespace {

using table::Table;

constexpr std::array kCodings{Coding::label, Coding::one_hot, Coding::exchangeable};

Table inputs_table(const std::vector<Input>& inputs, const std::vector<std::string>& names) {
  std::vector<double> lower;
  std::vector<double> upper;
  std::vector<std::string> scale;
  std::vector<std::string> coding;
  std::vector<std::int64_t> levels;
  for (const Input& input : inputs) {
    lower.push_back(input.lower);
    upper.push_back(input.upper);
    scale.emplace_back(input.scale == Scale::log ? "log" : "linear");
    coding.emplace_back(to_string(input.coding));
    levels.push_back(static_cast<std::int64_t>(input.levels.size()));
  }
  Table t;
  add_column(t, "name", names);
  add_column(t, "lower", lower);
  add_column(t, "upper", upper);
  add_column(t, "scale", scale);
  add_column(t, "levels", levels);
  add_column(t, "coding", coding);
  return t;
}

/// Of all categories, one after another.
Table levels_table(const std::vector<Input>& inputs, const std::vector<std::string>& names) {
  std::vector<std::string> input;
  std::vector<std::string> level;
  for (std::size_t k = 0; k < names.size(); ++k)
    for (const std::string& name : inputs[k].levels) {
      input.push_back(names[k]);
      level.push_back(name);
    }
  Table t;
  add_column(t, "input", input);
  add_column(t, "level", level);
  return t;
}

/// The first version of Gaussian processes had numbers on linear scales only.
std::vector<Input> read_inputs(const ModelReader& file, const Table& t) {
  const std::vector<double> lower = t.numbers("lower");
  const std::vector<double> upper = t.numbers("upper");
  file.check(t.rows() > 0, "it has no inputs");
  std::vector<Input> inputs;
  for (std::size_t k = 0; k < t.rows(); ++k)
    inputs.push_back({.lower = lower[k], .upper = upper[k]});
  if (file.version() == 1 && !t.has("levels")) return inputs;
  const std::vector<std::int64_t> levels = t.integers("levels");
  std::vector<std::string> level;
  if (file.has_table("/levels")) level = file.read("/levels").texts("level");
  std::size_t next = 0;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    inputs[k].scale = t.texts("scale")[k] == "log" ? Scale::log : Scale::linear;
    inputs[k].coding = file.choice(t.texts("coding")[k], kCodings);
    for (std::int64_t l = 0; l < levels[k]; ++l) {
      file.check(next < level.size(), "/levels is too short");
      inputs[k].levels.push_back(level[next++]);
    }
  }
  return inputs;
}

/// What `read` makes of inputs; a column that is missing, of the wrong type or not finite is
/// damage.
template <class Read>
auto read_model(const ModelReader& file, Read read) {
  try {
    const Table inputs = file.read("/inputs");
    auto model = read(read_inputs(file, inputs));
    return std::tuple{std::move(model), inputs.texts("name"), file.get<std::string>("response")};
  } catch (const InputError& error) {
    file.damaged(error.what());
  }
}

}  // namespace

void save_regressor(const std::filesystem::path& path, const NamedRegressor& named) {
  if (static_cast<Eigen::Index>(named.inputs.size()) != named.model.dimension())
    throw InputError(fmt::format("{} input names for a model of {} inputs", named.inputs.size(),
                                 named.model.dimension()));
  ModelContent content = content_of(named.model);
  content.attributes["response"] = named.response;
  content.add("/inputs", inputs_table(named.model.inputs(), named.inputs));
  content.add("/levels", levels_table(named.model.inputs(), named.inputs));
  table::write_tables(path, content.tables, content.attributes);
}

NamedRegressor load_regressor(const std::filesystem::path& path) {
  const ModelReader file(path);
  const ModelKind& kind = kind_of(file);
  if (kind.read == read_gaussian_process) check_functions(file, {});
  auto [model, names, response] = read_model(
      file, [&](std::vector<Input> inputs) { return kind.read(file, std::move(inputs)); });
  return {std::move(model), std::move(names), std::move(response)};
}

void save_model(const std::filesystem::path& path, const NamedModel& model) {
  save_regressor(path, {GaussianProcessRegressor(model.model), model.inputs, model.response});
}

NamedModel load_model(const std::filesystem::path& path, const BasisFunctions& functions) {
  const ModelReader file(path);
  const ModelKind& kind = kind_of(file);
  if (kind.read != read_gaussian_process)
    throw InputError(
        fmt::format("model file '{}' holds {}; what is asked for needs a Gaussian "
                    "process: fit one with --model gpr",
                    path.string(), load_regressor(path).model.describe()));
  check_functions(file, functions);
  auto [model, names, response] = read_model(file, [&](std::vector<Input> inputs) {
    return read_process(file, std::move(inputs), functions);
  });
  return {std::move(model), std::move(names), std::move(response)};
}

}  // namespace repose::surrogate
