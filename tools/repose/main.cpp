// repose: calibrates granular simulations; see `repose --help`.
#include <fmt/format.h>

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/campaign.hpp"

namespace repose::cli {
namespace {

constexpr int kInterrupted = 130;  // as a shell reports a program that Ctrl-C ended
std::string typed;

int run(int argc, char** argv) {
  for (int i = 0; i < argc; ++i) typed += (i > 0 ? " " : "") + std::string(argv[i]);
  CLI::App app{"Calibrates discrete element models of granular materials with few simulations.",
               "repose"};
  app.set_version_flag("--version", std::string("repose ") + version());
  app.require_subcommand(1);
  app.footer(
      "Example: repose calibrate examples/01_drawdown_quick/study.toml -o quick\n"
      "Exit codes: 0 done, 1 internal error, 2 usage, 3 bad input, 4 numerical failure,\n"
      "            5 simulation failure, 6 file or storage, 130 stopped by Ctrl-C.");
  add_calibrate(app);
  add_simulate(app);
  add_campaign(app);
  add_scenario(app);
  add_measure(app);
  add_design(app);
  add_screen(app);
  add_variance(app);
  add_fit(app);
  add_compare(app);
  add_cv(app);
  add_predict(app);
  add_sensitivity(app);
  add_sample(app);
  add_optimise(app);
  add_table(app);
  add_transfer(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorKind::usage);
  }
  return 0;
}

}  // namespace

CLI::App* add_command(CLI::App& parent, const std::string& name, const std::string& description,
                      const std::string& example, CommonOptions& common) {
  auto* command = parent.add_subcommand(name, description);
  command->add_flag("--json", common.json, "print the result as JSON");
  command->add_flag("--quiet", common.quiet, "no progress");
  command->footer("Example: " + example);
  return command;
}

void refuse_options(const CLI::App& command, std::initializer_list<const char*> options,
                    const std::string& why) {
  for (const char* option : options)
    if (command.count(option) > 0)
      throw InputError(fmt::format("{} has no meaning {}; leave it out", option, why));
}

const std::string& command_line() {
  return typed;
}

}  // namespace repose::cli

namespace {

/// The last words of a program that reads a file whose damage breaks the HDF5 library itself.
extern "C" void end_after_crash(int) {
  constexpr char kWords[] =
      "repose: crashed. If it was reading an HDF5 or MATLAB file, that file is damaged in a way "
      "that "
      "the HDF5 library\ndoes not survive: make it anew or take a copy. Otherwise please report "
      "the "
      "command.\n";
  static_cast<void>(!write(STDERR_FILENO, kWords, sizeof kWords - 1));
  _exit(static_cast<int>(repose::ErrorKind::internal));
}

}  // namespace

int main(int argc, char** argv) {
  using repose::ErrorKind;
#ifndef __SANITIZE_ADDRESS__  // which tells more
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) std::signal(signal, &end_after_crash);
#endif
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like a full disk
  try {
    return repose::cli::run(argc, argv);
  } catch (const repose::Error& error) {
    fmt::print(stderr, "repose: {}\n", error.what());
    return error.exit_code();
  } catch (const repose::dem_adapter::Interrupted&) {
    fmt::print(stderr, "\nrepose: stopped; the same command goes on from here\n");
    return repose::cli::kInterrupted;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "repose: out of memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "repose: internal error: {}; please report it\n", error.what());
  }
  return static_cast<int>(ErrorKind::internal);
}
