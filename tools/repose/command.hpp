// What every subcommand of `repose` shares; each stands in a file of its own.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <memory>
#include <string>

#include "repose/base/error.hpp"
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

/// The one of `values` that is called `text`; CLI11 has checked that there is one.
template <class Enum>
Enum named(const std::string& text, std::initializer_list<Enum> values) {
  for (const Enum value : values)
    if (text == to_string(value)) return value;
  throw InputError("'" + text + "' is not known");
}

/// Throws InputError for options that were given but mean nothing, `why` in words.
void refuse_options(const CLI::App& command, std::initializer_list<const char*> options,
                    const std::string& why);

/// The command line as typed, for provenance.
const std::string& command_line();

void add_calibrate(CLI::App& app);
void add_campaign(CLI::App& app);
void add_compare(CLI::App& app);
void add_cv(CLI::App& app);
void add_design(CLI::App& app);
/// Below `repose design`, one file each.
void add_design_check(CLI::App& design);
void add_design_factorial(CLI::App& design);
void add_design_filling(CLI::App& design);
void add_design_optimal(CLI::App& design);
void add_design_screening(CLI::App& design);
void add_design_surface(CLI::App& design);
void add_fit(CLI::App& app);
void add_measure(CLI::App& app);
void add_optimise(CLI::App& app);
void add_predict(CLI::App& app);
void add_sample(CLI::App& app);
void add_scenario(CLI::App& app);
void add_screen(CLI::App& app);
void add_sensitivity(CLI::App& app);
void add_simulate(CLI::App& app);
void add_table(CLI::App& app);
/// import and export, below `repose table`.
void add_table_conversions(CLI::App& table);
void add_transfer(CLI::App& app);
void add_variance(CLI::App& app);

}  // namespace repose::cli
