#include <gtest/gtest.h>

#include "repose/base/file.hpp"
#include "repose/scene/case.hpp"

namespace repose::scene {
namespace {

/// The ```toml blocks of a page.
std::vector<std::string> toml_blocks(const std::string& text) {
  const std::string begin = "```toml\n";
  std::vector<std::string> blocks;
  for (auto at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    at += begin.size();
    blocks.push_back(text.substr(at, text.find("```", at) - at));
  }
  return blocks;
}

TEST(HowTo, OfTheEngineShowsValidCases) {
  const auto blocks = toml_blocks(read_file(REPOSE_SOURCE_DIR "/docs/how-to/engine.md"));
  EXPECT_EQ(blocks.size(), 3u);
  for (const std::string& block : blocks) EXPECT_NO_THROW(parse_case(block, "engine.md")) << block;
}

}  // namespace
}  // namespace repose::scene
