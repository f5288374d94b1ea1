// Every input that the fuzzers kept, and those that once broke something, again.
#include <gtest/gtest.h>

#include <filesystem>

#include "readers.hpp"
#include "repose/base/file.hpp"

// HDF5 1.10 itself leaks a few blocks when it gives up on a damaged file, and asks for more memory
// than there is; both as under scripts/fuzz.
extern "C" const char* __lsan_default_suppressions();  // NOLINT: the sanitizer's name
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}
extern "C" const char* __asan_default_options();  // NOLINT: the sanitizer's name
extern "C" const char* __asan_default_options() {
  return "allocator_may_return_null=1";
}

namespace repose::fuzz {
namespace {

struct Replayed {
  int files = 0, tables = 0;
};

Replayed replay(const char* corpus, int (*check)(std::string_view)) {
  Replayed replayed;
  const auto folder = std::filesystem::path(REPOSE_TEST_DATA) / "fuzz" / corpus;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().filename().string());
    replayed.tables += check(read_file(entry.path()));
    ++replayed.files;
  }
  return replayed;
}

TEST(FuzzCorpus, OfCsvIsReadOrRefused) {
  const Replayed replayed = replay("csv", check_csv);
  EXPECT_GT(replayed.files, 100);
  EXPECT_GT(replayed.tables, 50);
}

TEST(FuzzCorpus, OfHdf5IsReadOrRefused) {
  const Replayed replayed = replay("hdf5", check_hdf5);
  EXPECT_GT(replayed.files, 20);
  EXPECT_GT(replayed.tables, 20);
}

}  // namespace
}  // namespace repose::fuzz
