// Runs the programs as a user does and keeps what they say.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace repose::test {

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct Said {
  int code = -1;  ///< exit code, or 128 + signal as a shell reports it
  std::string out, err;
};

/// A working directory for one test in which programs of build/bin are run.
class Workbench {
 public:
  Workbench() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("repose_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" +
               std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~Workbench() {
    std::error_code code;
    std::filesystem::remove_all(folder_, code);
  }
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  /// `arguments` is shell text; the program's name is looked up in build/bin.
  Said run(const std::string& program, const std::string& arguments) const {
    const auto out = folder_ / ".stdout", err = folder_ / ".stderr";
    const std::string command = "cd '" + folder_.string() + "' && '" REPOSE_BIN "/" + program +
                                "' " + arguments + " >.stdout 2>.stderr </dev/null";
    const int status = std::system(command.c_str());
    Said said{.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
              .out = text_of(out),
              .err = text_of(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return said;
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  /// Names in the folder, hidden ones too.
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace repose::test
