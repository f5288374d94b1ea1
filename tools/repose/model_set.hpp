// Fitted models and what is wanted of them, as one objective over the parameters: what `repose
// sample` and `repose optimise` share.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "repose/opt/composite.hpp"
#include "repose/opt/search_space.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/table.hpp"

namespace repose::cli {

struct ModelSetOptions {
  std::vector<std::string> models;
  std::vector<std::string> targets;
  std::vector<std::string> weights;
  std::vector<std::string> scales;
  std::vector<std::string> fixed;
  std::string factors;
  std::string runs;
  std::string loss = "absolute";
  bool maximise = false;
};

/// Adds MODEL... and the options for what is wanted and where.
void add_model_set_options(CLI::App& command, ModelSetOptions& options);

/// Points of the free parameters, one a row.
struct Points {
  Matrix natural;
  Matrix coordinates;  ///< of the search space
};

/// Models of several responses over one space of parameters.
class ModelSet {
 public:
  /// Loads the models. Parameters are those of the factors file, else the models' inputs; ranges
  /// that differ between models are cut to what is common. Throws InputError for a target without
  /// a model and a model without a target, an input that is no parameter, a parameter that is no
  /// input, a range that is empty.
  explicit ModelSet(const ModelSetOptions& options);

  const opt::SearchSpace& space() const { return space_; }
  const std::vector<surrogate::NamedModel>& models() const { return models_; }
  const std::vector<opt::Target>& targets() const { return targets_; }  ///< empty: one response
  bool maximises() const { return maximise_; }

  /// Of the coordinates of space(), one for each model; of minus the response where it is
  /// maximised.
  const std::vector<opt::Surrogate>& surrogates() const { return surrogates_; }
  /// The runs done: those of a table, else the points the models were fitted to that have the
  /// values that fixed and tied parameters have here.
  const Points& known() const { return known_; }
  /// The rows of a table that holds the free parameters. Throws InputError for values outside their
  /// ranges.
  Points points_of(const table::Table& table, const std::string& file) const;
  /// Throws InputError if a parameter has one of these names.
  void refuse_names(std::initializer_list<const char*> reserved) const;

  /// Mean of what is minimised: the expected weighted error, or the response (or minus it).
  Vector objective_means(const Matrix& coordinates) const;
  /// "weighted error of shear_angle_deg, mass_kg" or "angle_deg".
  std::string objective_name() const;

  /// `run` from 1, free, fixed and tied parameters, and of each response NAME_predicted,
  /// NAME_function_sd, NAME_extrapolated (1: outside a range or far from its data).
  table::Table runs(const Matrix& natural) const;

 private:
  struct Mapping;
  void read_targets(const ModelSetOptions& options);
  void refuse_unused_parameters() const;
  void add_known_points();
  /// Of a point of model j; nothing where it is none of this space.
  std::optional<Vector> natural_of(std::size_t j, const Vector& inputs) const;
  bool within_ranges(const Vector& natural) const;
  Points points_from(const std::vector<Vector>& rows) const;
  static ParameterSpace parameters_of(const std::vector<surrogate::NamedModel>& models,
                                      const ModelSetOptions& options,
                                      std::vector<Parameter>& named);

  std::vector<surrogate::NamedModel> models_;
  std::vector<Parameter> named_;  ///< all that are free or were before --fix
  opt::SearchSpace space_;
  std::vector<opt::Target> targets_;
  std::vector<std::shared_ptr<const Mapping>> mappings_;
  std::vector<opt::Surrogate> surrogates_;
  Points known_;
  bool maximise_ = false;
};

}  // namespace repose::cli
