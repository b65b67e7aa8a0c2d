#include "cpplus/io/atomic_file.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using AtomicFileTest = FileTest;

TEST_F(AtomicFileTest, NothingAppearsBeforeCommit) {
  {
    AtomicFile file(path("new folder/a.txt"));
    file.stream() << "hello";
    EXPECT_FALSE(std::filesystem::exists(path("new folder/a.txt")));
    file.commit();
    EXPECT_EQ(read("new folder/a.txt"), "hello");
  }
  EXPECT_EQ(read("new folder/a.txt"), "hello");
}

TEST_F(AtomicFileTest, WithoutCommitTheOldFileStays) {
  write("a.txt", "old");
  {
    AtomicFile file(path("a.txt"));
    file.stream() << "new";
  }
  EXPECT_EQ(read("a.txt"), "old");
  EXPECT_EQ(num_files(), 1u);
  write_text_file(path("a.txt"), "new");
  EXPECT_EQ(read("a.txt"), "new");
  EXPECT_EQ(num_files(), 1u);
}

TEST_F(AtomicFileTest, FoldersAndPlacesThatCannotBeWrittenAreErrors) {
  EXPECT_ERROR(write_text_file("/proc/a.txt", ""), "/proc/a.txt: cannot write");
  EXPECT_ERROR(write_text_file("/proc/none/a.txt", ""), "/proc/none/a.txt: cannot make its folder");
  std::filesystem::create_directories(path("folder"));
  EXPECT_ERROR(write_text_file(path("folder"), ""), "folder: cannot write: is a folder");
  EXPECT_ERROR(write_text_file(path("folder") + "/", ""), "cannot write: no file name");
  write("file", "");
  EXPECT_ERROR(write_text_file(path("file") + "/a.txt", ""), "cannot make its folder");
}

TEST_F(AtomicFileTest, ReadOnlyFolderIsAnError) {
  std::filesystem::create_directories(path("locked"));
  std::filesystem::permissions(path("locked"), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const bool may_write_anyway = std::ofstream(path("locked/probe")).good();  // root may
  if (!may_write_anyway) {
    EXPECT_ERROR(write_text_file(path("locked/a.txt"), ""), "locked/a.txt: cannot write: Permission denied");
  }
  std::filesystem::permissions(path("locked"), std::filesystem::perms::owner_all);
  if (may_write_anyway) GTEST_SKIP() << "this user may write into a read-only folder";
}

TEST_F(AtomicFileTest, FullDiskIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "/dev/full is missing";
  // A temporary that leads to the full device: its name is made of the target's and the process's number.
  const std::string temporary = path(".a.txt." + std::to_string(getpid()) + ".partial");
  std::filesystem::create_symlink("/dev/full", temporary);
  AtomicFile file(path("a.txt"));
  file.stream() << std::string(100000, 'x');
  EXPECT_ERROR(file.commit(), "a.txt: cannot write all of it");
}

}  // namespace
}  // namespace cpplus
