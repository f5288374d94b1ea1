// Independent tasks: every index once, results independent of the number of threads.
#include "repose/base/thread_pool.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace repose {
namespace {

TEST(ParallelFor, RunsEveryIndexOnceForAnyNumberOfThreads) {
  for (const unsigned threads : {0U, 1U, 2U, 8U, 100U}) {
    std::vector<int> calls(37, 0);
    parallel_for(calls.size(), threads, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(37, 1)) << threads << " threads";
  }
  parallel_for(0, 4, [](std::size_t) { FAIL(); });
}

TEST(ParallelFor, RethrowsTheExceptionOfTheLowestIndex) {
  for (const unsigned threads : {1U, 4U}) {
    try {
      parallel_for(50, threads, [](std::size_t i) {
        if (i >= 3) throw std::runtime_error(std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "3");
    }
  }
}

}  // namespace
}  // namespace repose
