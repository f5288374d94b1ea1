// The layers of docs/architecture.md, held by reading every #include of the tree.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

const fs::path kRoot = REPOSE_SOURCE_DIR;

/// Folder -> (its own name in include paths, what it may include).
const std::map<std::string, std::pair<std::string, Names>>& layers() {
  static const std::map<std::string, std::pair<std::string, Names>> kLayers{
      {"libbase", {"base", {}}},
      {"libplot", {"plot", {"base"}}},
      {"libtable", {"table", {"base", "plot"}}},
      {"libdoe", {"doe", {"base", "plot", "table"}}},
      {"libopt", {"opt", {"base", "plot", "table", "doe"}}},
      {"libsurrogate", {"surrogate", {"base", "plot", "table", "doe", "opt"}}},
      {"libscene", {"scene", {"base", "plot", "table"}}},
      {"dem_core", {"dem", {"base", "plot", "table", "scene"}}},
      {"dem_adapter",
       {"dem_adapter", {"base", "plot", "table", "doe", "opt", "surrogate", "scene"}}},
      {"tools/repose",
       {"cli", {"base", "plot", "table", "doe", "opt", "surrogate", "scene", "dem_adapter"}}}};
  return kLayers;
}

std::vector<fs::path> sources_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".cpp" || entry.path().extension() == ".hpp")
      files.push_back(entry.path());
  return files;
}

/// Targets of all #include lines, with their < or ".
std::vector<std::string> includes_of(const fs::path& file) {
  static const std::regex kInclude(R"(^\s*#\s*include\s*([<"][^>"]+)[>"])");
  std::vector<std::string> includes;
  std::ifstream in(file);
  std::smatch match;
  for (std::string line; std::getline(in, line);)
    if (std::regex_search(line, match, kInclude)) includes.push_back(match[1]);
  return includes;
}

TEST(IncludeGraph, EveryFolderIncludesOnlyWhatItsArrowReaches) {
  static const std::regex kOurs(R"(^["<]repose/([a-z_]+)/)");
  std::size_t checked = 0;
  for (const auto& [folder, layer] : layers()) {
    ASSERT_TRUE(fs::is_directory(kRoot / folder)) << folder;
    for (const auto& file : sources_in(kRoot / folder))
      for (const auto& include : includes_of(file)) {
        std::smatch match;
        if (!std::regex_search(include, match, kOurs)) continue;
        ++checked;
        EXPECT_TRUE(match[1] == layer.first || layer.second.count(match[1]) == 1)
            << file << " includes " << include.substr(1);
      }
  }
  EXPECT_GT(checked, 100U);
}

TEST(IncludeGraph, PublicHeadersNeedNothingButEigenAndTheStandardLibrary) {
  std::size_t checked = 0;
  for (const auto& [folder, layer] : layers()) {
    if (!fs::is_directory(kRoot / folder / "include")) continue;
    for (const auto& file : sources_in(kRoot / folder / "include"))
      for (const auto& include : includes_of(file)) {
        ++checked;
        const bool ours = include.rfind("\"repose/", 0) == 0;
        const bool eigen = include.rfind("<Eigen/", 0) == 0;
        const bool standard = include[0] == '<' && include.find_first_of("/.") == std::string::npos;
        EXPECT_TRUE(ours || eigen || standard) << file << " includes " << include.substr(1);
      }
  }
  EXPECT_GT(checked, 100U);
}

TEST(IncludeGraph, OnlyTheEngineMayKnowMpi) {
  for (const auto& [folder, layer] : layers()) {
    if (folder == "dem_core") continue;
    for (const auto& file : sources_in(kRoot / folder))
      for (const auto& include : includes_of(file)) EXPECT_NE(include, "<mpi.h") << file;
  }
}

}  // namespace
