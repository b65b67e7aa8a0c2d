#include "cpplus/pipeline/image_folder.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using testing::ElementsAre;

class ImageFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = std::filesystem::path(testing::TempDir()) /
                 (std::string("image_folder_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_ / "left");
  }
  void touch(const std::string& name) { std::ofstream(directory_ / name) << "x"; }
  void add_image(const std::string& name) {
    PosedImage image;
    image.id = static_cast<uint32_t>(model_.images.size() + 1);
    image.name = name;
    model_.images.push_back(image);
  }

  std::filesystem::path directory_;
  SparseModel model_;
};

TEST_F(ImageFolderTest, SortsImagesByWhatIsThere) {
  for (const char* name : {"b.JPG", "left/a.png", "stray.png", "left/c.jpeg", "notes.txt"}) touch(name);
  for (const char* name : {"gone.jpg", "left/a.png", "b.JPG"}) add_image(name);
  const ImageFolder folder = find_images(directory_.string(), model_);
  EXPECT_THAT(folder.with_file, ElementsAre(1, 2));
  EXPECT_THAT(folder.missing, ElementsAre(0));
  EXPECT_THAT(folder.without_pose, ElementsAre("left/c.jpeg", "stray.png"));
}

TEST_F(ImageFolderTest, WarnsOncePerKind) {
  for (const char* name : {"a.png", "s.png", "t.png"}) touch(name);
  for (const char* name : {"a.png", "gone.jpg"}) add_image(name);
  testing::internal::CaptureStderr();
  warn_of_unmatched("DIR", model_, find_images(directory_.string(), model_));
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "warning: DIR: 1 image of the model not found, the first is 'gone.jpg'\n"
            "warning: DIR: 2 images without a pose not used, the first is 's.png'\n");
}

TEST(DebugImageName, IsFlatAndPng) {
  EXPECT_EQ(debug_image_name("a.jpg"), "a.png");
  EXPECT_EQ(debug_image_name("left/cam.0/a.b.jpeg"), "left_cam.0_a.b.png");
}

TEST_F(ImageFolderTest, NothingToWorkOnIsAnError) {
  add_image("gone.jpg");
  EXPECT_THROW(find_images(directory_.string(), model_), Error);
  EXPECT_THROW(find_images(directory_.string() + "/none", model_), Error);
  touch("file");
  EXPECT_THROW(find_images(directory_.string() + "/file", model_), Error);
  EXPECT_THROW(find_images(directory_.string(), SparseModel()), Error);
}

}  // namespace
}  // namespace cpplus
