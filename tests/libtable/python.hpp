// Python scripts with h5py, as other writers and readers of our files.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "repose/base/file.hpp"

namespace repose::table {

/// Runs a script in `folder` in which `h5py` and `np` are imported and `path` names "t.h5"; it must
/// succeed.
inline void run_python(const std::filesystem::path& folder, const std::string& script) {
  write_file_atomically(folder / "script.py", "import h5py, numpy as np\npath = '" +
                                                  (folder / "t.h5").string() + "'\n" + script);
  const std::string command = "/usr/bin/python3 '" + (folder / "script.py").string() + "' >'" +
                              (folder / "log").string() + "' 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_file(folder / "log");
}

}  // namespace repose::table
