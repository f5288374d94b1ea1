// A folder with sbatch, squeue and scancel of ours, first on PATH for one test.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace repose::test {

class StandIn {
 public:
  explicit StandIn(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_);
    for (const char* name : {"sbatch", "squeue", "scancel"})
      std::filesystem::copy_file(REPOSE_SOURCE_DIR "/tests/slurm/stand_in.py", folder_ / name);
    path_ = std::getenv("PATH");
    ::setenv("PATH", (folder_.string() + ":" + path_).c_str(), 1);
  }
  ~StandIn() { ::setenv("PATH", path_.c_str(), 1); }
  StandIn(const StandIn&) = delete;
  StandIn& operator=(const StandIn&) = delete;

  /// Makes it do what stand_in.py says of this file.
  void set(const std::string& name, const std::string& text = "") const {
    std::ofstream(folder_ / name) << text;
  }
  void unset(const std::string& name) const { std::filesystem::remove(folder_ / name); }
  /// How often a program was called.
  int calls(const std::string& program) const {
    int n = 0;
    std::ifstream in(folder_ / "calls");
    for (std::string line; std::getline(in, line);) n += line.starts_with(program) ? 1 : 0;
    return n;
  }
  std::string last_call(const std::string& program) const {
    std::string last;
    std::ifstream in(folder_ / "calls");
    for (std::string line; std::getline(in, line);)
      if (line.starts_with(program)) last = line;
    return last;
  }
  /// Tasks in the queue.
  std::size_t jobs() const {
    std::size_t n = 0;
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "jobs", code))
      n += entry.path().filename().string().front() != '.' ? 1 : 0;
    return n;
  }
  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

}  // namespace repose::test
