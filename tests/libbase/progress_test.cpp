// Progress lines: what they say and how wide they are.
#include "repose/base/progress.hpp"

#include <gtest/gtest.h>

namespace repose {
namespace {

TEST(ProgressLine, ShowsShareAndTimeLeft) {
  EXPECT_EQ(progress_line("runs", 25, 100, 50.0, 0, "", 100),
            "runs [#####...............]  25 %  2 min 30 s left");
}

TEST(ProgressLine, CountsOnlyWhatThisProcessDidTowardsTheRate) {
  // 50 of 100 stood at the start, 25 took 10 s, so 25 more take 10 s.
  EXPECT_EQ(progress_line("runs", 75, 100, 10.0, 50, "x", 100),
            "runs [###############.....]  75 %  10 s left  x");
}

TEST(ProgressLine, NeverExceedsItsWidth) {
  const auto line = progress_line("runs", 1, 3, 10.0, 0, std::string(300, 'x'), 100);
  EXPECT_EQ(line.size(), 100U);
}

TEST(ProgressLine, OfNothingToDoIsDefined) {
  EXPECT_EQ(progress_line("runs", 0, 0, 0.0, 0, "", 100), "runs [....................]   0 %");
}

}  // namespace
}  // namespace repose
