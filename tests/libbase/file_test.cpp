// Files written whole or not at all.
#include "repose/base/file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "repose/base/error.hpp"

namespace repose {
namespace {

class FileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ =
        std::filesystem::temp_directory_path() / ("repose_file_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(directory_), {}));
  }
  std::filesystem::path directory_;
};

TEST_F(FileTest, WrittenTextReadsBackAndLeavesNoTemporary) {
  const std::string text("a\0b\nc", 5);
  write_file_atomically(directory_ / "x", "old");
  write_file_atomically(directory_ / "x", text);
  EXPECT_EQ(read_file(directory_ / "x"), text);
  EXPECT_EQ(files(), 1U);
}

TEST_F(FileTest, AFailedWriteLeavesTheOldFileAndNoTemporary) {
  std::filesystem::create_directories(directory_ / "taken" / "inside");  // cannot be renamed over
  EXPECT_THROW(write_file_atomically(directory_ / "taken", "text"), StorageError);
  EXPECT_TRUE(std::filesystem::is_directory(directory_ / "taken" / "inside"));
  EXPECT_EQ(files(), 1U);
}

TEST_F(FileTest, AMissingFileIsNamedWithTheReason) {
  try {
    read_file(directory_ / "nowhere.toml");
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("nowhere.toml"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("No such file"), std::string::npos);
    EXPECT_EQ(error.exit_code(), 6);
  }
}

}  // namespace
}  // namespace repose
