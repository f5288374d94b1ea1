// Every input that the fuzzers kept, and those that once broke something, again.
#include <gtest/gtest.h>

#include <filesystem>

#include "readers.hpp"
#include "repose/base/file.hpp"

namespace repose::fuzz {
namespace {

int replay(const char* corpus, void (*check)(std::string_view)) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(REPOSE_TEST_DATA) / "fuzz" / corpus)) {
    SCOPED_TRACE(entry.path().filename().string());
    check(read_file(entry.path()));
    ++count;
  }
  return count;
}

TEST(FuzzCorpus, OfCsvIsReadOrRefused) {
  EXPECT_GT(replay("csv", check_csv), 20);
}

TEST(FuzzCorpus, OfHdf5IsReadOrRefused) {
  EXPECT_GT(replay("hdf5", check_hdf5), 20);
}

}  // namespace
}  // namespace repose::fuzz
