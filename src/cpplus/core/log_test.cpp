#include "cpplus/core/log.h"

#include <gtest/gtest.h>

namespace cpplus {
namespace {

TEST(Log, QuietSilencesInformationButNotWarnings) {
  for (const bool quiet : {false, true}) {
    set_quiet(quiet);
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    log_info("12 images");
    log_warning("no stamps");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), quiet ? "" : "12 images\n");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: no stamps\n");
  }
  set_quiet(false);
}

}  // namespace
}  // namespace cpplus
