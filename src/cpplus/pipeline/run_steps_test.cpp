#include "cpplus/pipeline/run_steps.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

/// Two steps: the first copies a file, the second joins the copy with a folder's files.
class RunSteps : public FileTest {
 protected:
  RunSteps() {
    write("source.txt", "a");
    write("folder/sub/b.txt", "b");
    copy_in_ = path("source.txt");
    copy_out_ = path("copy.txt");
    join_in_ = path("copy.txt");
    join_folder_ = path("folder");
    join_out_ = path("joined.txt");
  }

  std::vector<RunStep> steps() {
    return {{"copy",
             {{"copy.in", "", &copy_in_}, {"copy.out", "", &copy_out_}},
             [this] {
               if (fails_) throw Error("no");
               write("copy.txt", read("source.txt"));
             }},
            {"join",
             {{"join.in", "", &join_in_},
              {"join.folder", "", &join_folder_},
              {"join.times", "", &times_},
              {"join.out", "", &join_out_}},
             [this] { write("joined.txt", read("copy.txt") + read("folder/sub/b.txt")); }},
            {"unused", {{"unused.out", "", &unused_out_}}, [] { FAIL() << "has no output, so it is not run"; }}};
  }

  /// "copy join": the names of the steps that were run, not skipped.
  std::string run() {
    std::string ran;
    for (const StepOutcome& outcome : run_steps(steps(), path("state"))) {
      if (!outcome.was_skipped) ran += (ran.empty() ? "" : " ") + outcome.name;
    }
    return ran;
  }

  std::string copy_in_, copy_out_, join_in_, join_folder_, join_out_, unused_out_;
  int times_ = 1;
  bool fails_ = false;
};

TEST_F(RunSteps, UnchangedStepsAreSkipped) {
  EXPECT_EQ(run(), "copy join");
  EXPECT_EQ(read("joined.txt"), "ab");
  EXPECT_EQ(run(), "");
}

TEST_F(RunSteps, AChangedInputRunsItsStepAndThoseAfterIt) {
  run();
  write("source.txt", "longer");
  EXPECT_EQ(run(), "copy join");
  EXPECT_EQ(read("joined.txt"), "longerb");
  write("folder/c.txt", "a file more");
  EXPECT_EQ(run(), "join");
  fs::remove(path("folder/c.txt"));
  EXPECT_EQ(run(), "join");
  EXPECT_EQ(run(), "");
}

TEST_F(RunSteps, AChangedOptionRunsItsStep) {
  run();
  times_ = 2;
  EXPECT_EQ(run(), "join");
}

TEST_F(RunSteps, AMissingOrChangedOutputIsMadeAgain) {
  run();
  fs::remove(path("joined.txt"));
  EXPECT_EQ(run(), "join");
  write("joined.txt", "edited by hand");
  EXPECT_EQ(run(), "join");
  EXPECT_EQ(read("joined.txt"), "ab");
}

TEST_F(RunSteps, AStepThatFailedIsTriedAgain) {
  run();
  write("source.txt", "new");
  fails_ = true;
  EXPECT_ERROR(run(), "no");
  fails_ = false;
  EXPECT_EQ(run(), "copy join");
}

}  // namespace
}  // namespace cpplus
