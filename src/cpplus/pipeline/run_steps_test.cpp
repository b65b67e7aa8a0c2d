#include "cpplus/pipeline/run_steps.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

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
              {"join.labels", "", &join_labels_},
              {"join.out", "", &join_out_}},
             [this] {
               write("joined.txt", read("copy.txt") + read("folder/sub/b.txt"));
               if (!join_labels_.empty()) write("labels/b.label", "b");
             },
             join_may_be_edited_},
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

  std::string copy_in_, copy_out_, join_in_, join_folder_, join_out_, join_labels_, unused_out_;
  int times_ = 1;
  bool fails_ = false;
  bool join_may_be_edited_ = false;
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

TEST_F(RunSteps, OutputsBesidesTheMainOneAreNoInputs) {
  join_labels_ = path("labels");
  EXPECT_EQ(run(), "copy join");
  EXPECT_EQ(run(), "");
  write("labels/other.txt", "not of the step");
  EXPECT_EQ(run(), "");
  fs::remove(path("labels/b.label"));
  EXPECT_EQ(run(), "join");
}

TEST_F(RunSteps, WhatMayBeEditedIsMadeAgainOnlyWhereItIsGone) {
  join_may_be_edited_ = true;
  run();
  write("joined.txt", "edited by hand");
  EXPECT_EQ(run(), "");
  fs::remove(path("joined.txt"));
  EXPECT_EQ(run(), "join");
}

TEST_F(RunSteps, AnotherVersionRunsAllSteps) {
  run();
  for (const char* name : {"state/copy.done", "state/join.done"}) {
    const std::string text = read(name);
    ASSERT_TRUE(text.starts_with("version: "));
    write(name, "version: 0.0.0" + text.substr(text.find('\n')));
  }
  EXPECT_EQ(run(), "copy join");
}

TEST_F(RunSteps, WhatAKilledRunLeftIsRemoved) {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  const std::string dead = fmt::format(".joined.txt.{}.partial", child);
  const std::string alive = fmt::format(".joined.txt.{}.partial", getppid());
  write(dead, "half");
  write(alive, "half");
  write(fmt::format(".other.txt.{}.partial", child), "of another program's file");
  run();
  EXPECT_FALSE(fs::exists(path(dead)));
  EXPECT_TRUE(fs::exists(path(alive)));
  EXPECT_TRUE(fs::exists(path(fmt::format(".other.txt.{}.partial", child))));
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
