// A scenario: a laboratory test as a family of simulations with parameters and KPIs.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/base/toml.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

/// What a run starts from: the text of its case.toml, which holds parameters and seed.
struct RunInput {
  std::uint64_t seed = 0;
  std::string text;
};

template <class S>
concept HasNames = requires(const S& s) {
  { s.name() } -> std::convertible_to<std::string>;
  { s.parameter_names() } -> std::convertible_to<std::vector<std::string>>;
  { s.kpi_names() } -> std::convertible_to<std::vector<std::string>>;
};

/// A scenario of cases, which any engine can run that simulates particles.
template <class S>
concept CaseScenario = HasNames<S> &&
    requires(const S& s, const ParameterValues& values, const scene::Run& run) {
  { s.make_case(values, std::uint64_t{}) } -> std::convertible_to<scene::Case>;
  { s.measure(run) } -> std::convertible_to<Measurement>;
};

/// A scenario whose input and output only its own engine understands.
template <class S>
concept TextScenario = HasNames<S> &&
    requires(const S& s, const ParameterValues& values, const std::filesystem::path& output,
             const Executor& executor) {
  { s.make_input(values, std::uint64_t{}) } -> std::convertible_to<RunInput>;
  { s.measure(output) } -> std::convertible_to<Measurement>;
  { s.make_engine(executor) } -> std::convertible_to<Engine>;
};

template <class S>
concept ScenarioLike = CaseScenario<S> || TextScenario<S>;

/// A scenario whose KPIs are defined by its user: a text that changes with them.
template <class S>
concept DefinesKpis = requires(const S& s) {
  { s.kpi_definition() } -> std::convertible_to<std::string>;
};

RunInput input_of(const scene::Case& scene);  ///< throws InputError as scene::validate() does

/// Any scenario as a value; copies share it, and it never changes.
class Scenario {
 public:
  template <ScenarioLike S>
  requires(!std::same_as<std::remove_cvref_t<S>, Scenario>) Scenario(S scenario)
      : model_(std::make_shared<const Model<S>>(std::move(scenario))) {}

  std::string name() const { return model_->name(); }
  /// Names that make_input() understands; each has a default.
  std::vector<std::string> parameter_names() const { return model_->parameter_names(); }
  std::vector<std::string> kpi_names() const { return model_->kpi_names(); }
  /// The simulation with these values in place of defaults. Names it does not know are ignored
  /// (they may be sources of ties); values out of range throw InputError naming them.
  RunInput make_input(const ParameterValues& values, std::uint64_t seed) const {
    return model_->make_input(values, seed);
  }
  /// Of what the engine left in its output folder. Throws InputError or StorageError if that is not
  /// what this scenario expects.
  Measurement measure(const std::filesystem::path& output) const { return model_->measure(output); }
  /// Runs with another definition are measured anew; empty if only code defines the KPIs.
  std::string kpi_definition() const { return model_->kpi_definition(); }
  /// Of a scenario that only its own engine can run, which then uses this executor.
  std::optional<Engine> own_engine(const Executor& executor) const {
    return model_->own_engine(executor);
  }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual std::string name() const = 0;
    virtual std::vector<std::string> parameter_names() const = 0;
    virtual std::vector<std::string> kpi_names() const = 0;
    virtual RunInput make_input(const ParameterValues& values, std::uint64_t seed) const = 0;
    virtual Measurement measure(const std::filesystem::path& output) const = 0;
    virtual std::string kpi_definition() const = 0;
    virtual std::optional<Engine> own_engine(const Executor& executor) const = 0;
  };
  template <class S>
  struct Model final : Interface {
    explicit Model(S s) : scenario(std::move(s)) {}
    std::string name() const override { return scenario.name(); }
    std::vector<std::string> parameter_names() const override { return scenario.parameter_names(); }
    std::vector<std::string> kpi_names() const override { return scenario.kpi_names(); }
    RunInput make_input(const ParameterValues& values, std::uint64_t seed) const override {
      if constexpr (CaseScenario<S>)
        return input_of(scenario.make_case(values, seed));
      else
        return scenario.make_input(values, seed);
    }
    Measurement measure(const std::filesystem::path& output) const override {
      if constexpr (CaseScenario<S>)
        return scenario.measure(scene::read_run(output));
      else
        return scenario.measure(output);
    }
    std::string kpi_definition() const override {
      if constexpr (DefinesKpis<S>)
        return scenario.kpi_definition();
      else
        return {};
    }
    std::optional<Engine> own_engine(const Executor& executor) const override {
      if constexpr (TextScenario<S>)
        return scenario.make_engine(executor);
      else
        return std::nullopt;
    }
    S scenario;
  };
  std::shared_ptr<const Interface> model_;
};

/// Reads `scenario = "NAME"` and what belongs to it from a table. Throws InputError.
Scenario read_scenario(const TomlTable& table);
/// The same from a file that holds nothing else.
Scenario read_scenario_file(const std::filesystem::path& path);
/// The same from the key `scenario` of a study: a table, or a file named relative to `folder`.
Scenario read_scenario_key(const TomlTable& root, const std::filesystem::path& folder);

}  // namespace repose::dem_adapter
