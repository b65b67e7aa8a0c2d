#include "cpplus/core/progress.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(Progress, LineShowsTheShareDone) {
  EXPECT_EQ(progress_line("refine", 0, 4, 8), "refine  [>       ]  0/4");
  EXPECT_EQ(progress_line("refine", 1, 4, 8), "refine  [==>     ]  1/4");
  EXPECT_EQ(progress_line("refine", 4, 4, 8), "refine  [========]  4/4");
  EXPECT_EQ(progress_line("refine", 0, 0, 4), "refine  [====]  0/0");
  EXPECT_EQ(progress_line("refine", 9, 4, 4), "refine  [====]  9/4");
}

TEST(Progress, PrintsNothingWhereStderrIsNotATerminal) {
  testing::internal::CaptureStderr();  // stderr is a file now
  {
    Progress progress("refine", 3);
    progress.advance();
    progress.advance(2);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace cpplus
