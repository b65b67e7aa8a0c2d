#include "cpplus/pipeline/checkerboard_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

class CheckerboardJson : public testing::Test {
 protected:
  std::string path_ =
      (std::filesystem::temp_directory_path() /
       (std::string("cpplus_boards_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".json"))
          .string();
  void TearDown() override { std::filesystem::remove(path_); }

  std::vector<Checkerboard> read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_checkerboards(path_);
  }
  std::string message(const std::string& text) {
    try {
      read(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(CheckerboardJson, ReadsCornersAndTurnsPixelsIntoOurConvention) {
  const auto boards = read(R"({"boards": [{"name": "A", "corners_3d": [[1, 2, 3], [4, 5, 6]],
                               "images": {"a.jpg": {"corners_2d": [[10.5, 20.5], [30, 40]]}}}]})");
  ASSERT_EQ(boards.size(), 1u);
  EXPECT_EQ(boards[0].corners_in_map[1], Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(boards[0].sightings.size(), 1u);
  EXPECT_EQ(boards[0].sightings[0].image_name, "a.jpg");
  EXPECT_EQ(boards[0].sightings[0].corner_pixels[0], Eigen::Vector2d(10, 20));
}

TEST_F(CheckerboardJson, NamesTheFileAndTheFault) {
  EXPECT_THAT(message("{"), testing::HasSubstr(path_));
  EXPECT_THAT(message("{}"), testing::HasSubstr("boards"));
  EXPECT_THAT(message(R"({"boards": [{"name": "A", "corners_3d": [[1, 2]], "images": {}}]})"),
              testing::HasSubstr("expected 3 numbers, got 2"));
  EXPECT_THAT(message(R"({"boards": [{"name": "A", "corners_3d": [[1, 2, 3]],
                          "images": {"a.jpg": {"corners_2d": []}}}]})"),
              testing::HasSubstr("image a.jpg has 0 corners, the board 1"));
  EXPECT_THROW(read_checkerboards("/nowhere/boards.json"), Error);
}

}  // namespace
}  // namespace cpplus
