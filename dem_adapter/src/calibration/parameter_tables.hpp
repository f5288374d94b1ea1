// [ties] and [fixed] of a file, checked against what its scenario knows.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/base/toml.hpp"

namespace repose::dem_adapter {

struct TiesAndFixed {
  std::vector<Tie> ties;
  std::set<std::string> sources;  ///< names that ties build on
  ParameterValues fixed;
};
/// Throws InputError with file and line for a name that nothing would use.
TiesAndFixed read_ties_and_fixed(const TomlTable& root, const std::vector<std::string>& known);

/// What is wrong with a name that neither the scenario knows nor a tie builds on; else empty.
std::string unknown_name(const std::string& name, const std::vector<std::string>& known,
                         const std::set<std::string>& sources);

/// What is wrong with a parameter's name as that of a column of the tables of runs; else empty.
std::string unusable_name(const std::string& name, const std::vector<std::string>& kpis);

}  // namespace repose::dem_adapter
