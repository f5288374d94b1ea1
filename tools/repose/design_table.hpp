// What the commands that make designs share: their options, the table they write, what they say.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "repose/base/parameter_space.hpp"
#include "repose/table/table.hpp"

namespace repose::cli {

/// Options of every command that makes a design.
struct DesignOptions {
  CommonOptions common;
  std::string factors;
  std::string output;
  std::uint64_t seed = 1;
  std::string run_order = "randomised";
};

/// Adds a command with -o, --seed, --json, --quiet and an example. `arguments` follows the name in
/// the example.
CLI::App* add_design_kind(CLI::App& group, const std::string& name, const std::string& description,
                          const std::string& arguments, DesignOptions& options);
/// Adds --factors, with what such a file looks like.
void add_factors_file(CLI::App& command, DesignOptions& options);
/// Adds --run-order randomised|structured.
void add_run_order(CLI::App& command, DesignOptions& options);
void add_centre_runs(CLI::App& command, int& centre_runs, const std::string& description);

/// Rows in the order in which they shall be run: 0, 1, ... or shuffled by the seed.
std::vector<Eigen::Index> run_order(Eigen::Index runs, const DesignOptions& options);

/// Coded levels -1 ... 1 as places 0 ... 1.
Matrix unit_of(const Matrix& coded);

enum class Needs {
  two_levels,    ///< -1 and 1: no names but two
  three_levels,  ///< -1, 0 and 1: a middle as well
  any_distance,  ///< levels anywhere between: continuous parameters
};
/// Throws InputError naming a parameter that cannot take the levels of `design`.
void require_levels(const ParameterSpace& space, Needs needs, const std::string& design);

/// `run` from 1, the factors decoded, then fixed and tied parameters.
table::Table design_table(const ParameterSpace& space, const Matrix& unit);
/// The same of values in natural units.
table::Table runs_table(const ParameterSpace& space, const Matrix& natural);

/// A design, as it is written and reported.
struct MadeDesign {
  std::string kind;                     ///< "latin hypercube"
  table::Table table;                   ///< as design_table() makes it, with what else belongs
  std::vector<std::string> lines = {};  ///< what a reader should know of it
  nlohmann::json facts = nlohmann::json::object();  ///< the same for machines
  std::vector<std::string> parents = {};            ///< files it was made from besides the factors
};

/// Adds an integer column, one value a run.
void add_integers(table::Table& table, const std::string& name, const std::vector<int>& values);

/// Writes the table with its provenance and prints what was made; names the runs that break
/// constraints, on stderr and as `broken_constraints`.
void finish(const DesignOptions& options, const ParameterSpace& space, MadeDesign design);

}  // namespace repose::cli
