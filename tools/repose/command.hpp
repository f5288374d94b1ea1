// What every subcommand of `repose` shares; each stands in a file of its own.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "repose/base/progress.hpp"

namespace repose::cli {

/// Options of every subcommand.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  ProgressStyle progress_style() const {
    return quiet ? ProgressStyle::quiet : ProgressStyle::automatic;
  }
};

/// Adds --json and --quiet to a subcommand and returns it with its example in the footer.
CLI::App* add_command(CLI::App& parent, const std::string& name, const std::string& description,
                      const std::string& example, CommonOptions& common);

/// The command line as typed, for provenance.
const std::string& command_line();

void add_calibrate(CLI::App& app);
void add_design(CLI::App& app);
/// Below `repose design`, one file each.
void add_design_check(CLI::App& design);
void add_design_factorial(CLI::App& design);
void add_design_filling(CLI::App& design);
void add_design_optimal(CLI::App& design);
void add_design_screening(CLI::App& design);
void add_design_surface(CLI::App& design);
void add_fit(CLI::App& app);
void add_predict(CLI::App& app);
void add_screen(CLI::App& app);
void add_sensitivity(CLI::App& app);
void add_simulate(CLI::App& app);
void add_table(CLI::App& app);
/// import and export, below `repose table`.
void add_table_conversions(CLI::App& table);
void add_variance(CLI::App& app);

}  // namespace repose::cli
