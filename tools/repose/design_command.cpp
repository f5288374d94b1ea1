// repose design: makes the runs of an experiment as a table, and checks them.
#include "command.hpp"

namespace repose::cli {

void add_design(CLI::App& app) {
  auto* group = app.add_subcommand("design", "Designs experiments and checks designs");
  group->require_subcommand(1);
  add_design_screening(*group);
  add_design_filling(*group);
  add_design_factorial(*group);
  add_design_surface(*group);
  add_design_optimal(*group);
  add_design_check(*group);
}

}  // namespace repose::cli
