#include "cpplus/core/progress.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(Progress, LineShowsTheShareDone) {
  EXPECT_EQ(progress_line("refine", 0, 4, 0.0, 8), "refine  [>       ]  0/4");
  EXPECT_EQ(progress_line("refine", 1, 4, 0.0, 8), "refine  [==>     ]  1/4");
  EXPECT_EQ(progress_line("refine", 4, 4, 0.0, 8), "refine  [========]  4/4");
  EXPECT_EQ(progress_line("refine", 0, 0, 1.0, 4), "refine  [====]  0/0");
  EXPECT_EQ(progress_line("refine", 9, 4, 0.0, 4), "refine  [====]  9/4");
}

TEST(Progress, LineShowsRateAndTimeLeft) {
  EXPECT_EQ(progress_line("refine", 12, 30, 3.0, 4), "refine  [=>  ]  12/30  4.0/s  5 s left");
  EXPECT_EQ(progress_line("refine", 1, 21, 30.0, 4), "refine  [>   ]  1/21  0.0/s  10 min left");
  EXPECT_EQ(progress_line("refine", 1, 1001, 18.0, 4), "refine  [>   ]  1/1001  0.1/s  5.0 h left");
}

TEST(Progress, JsonHasTheSameFigures) {
  EXPECT_EQ(progress_json("refine", 12, 30, 3.0),
            R"({"stage": "refine", "done": 12, "total": 30, "per_second": 4, "seconds_left": 4.5})");
  EXPECT_EQ(progress_json("refine", 0, 30, 3.0),
            R"({"stage": "refine", "done": 0, "total": 30, "per_second": null, "seconds_left": null})");
}

TEST(Progress, JsonIsWrittenAtStartAndEndWithoutATerminal) {
  testing::internal::CaptureStderr();
  set_json_progress(true);
  {
    Progress progress("refine", 2);
    progress.advance(2);
  }
  set_json_progress(false);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(text.find(R"({"stage": "refine", "done": 0, "total": 2,)"), 0u) << text;
  EXPECT_NE(text.find(R"("done": 2, "total": 2,)"), std::string::npos) << text;
  EXPECT_EQ(text.back(), '\n');
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
