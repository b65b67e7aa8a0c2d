#include "cpplus/pipeline/info_command.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"

namespace cpplus {
namespace {

using testing::ElementsAre;

class InfoCommand : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "info_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
  }
  std::string path(const std::string& name) const { return directory_ + "/" + name; }

  void make_map() {
    PointCloud cloud;
    cloud.positions = {{0.0f, 0.0f, 0.0f}, {4.0f, -2.0f, 1.5f}};
    cloud.intensities = {1.0f, 2.0f};
    write_point_cloud(path("map.pcd"), cloud);
  }
  void make_images() {
    std::filesystem::create_directories(path("images"));
    for (const char* name : {"a.png", "b.png"}) write_png(path("images/") + name, ColorImage(8, 6));
    write_png(path("images/c.png"), ColorImage(4, 6));
  }
  void make_model() {
    SparseModel model;
    model.cameras.emplace(7, Camera(CameraModel::kPinhole, 8, 6, {5.0, 5.0, 4.0, 3.0}));
    model.images.push_back({1, "a.png", 7, Rigid3(Eigen::Quaterniond::Identity(), {-1.0, 0.0, 0.0})});
    model.images.push_back({2, "b.png", 7, Rigid3(Eigen::Quaterniond::Identity(), {-3.0, 0.0, 0.0})});
    write_sparse_model_text(path("model"), model);
  }

  std::string directory_;
};

TEST_F(InfoCommand, DescribesASceneAndWhatItsPartsAre) {
  make_map();
  make_images();
  make_model();
  std::ofstream(path("stamps.txt")) << "a.png 1.5\nb.png 2\n";
  std::ofstream(path("notes.txt")) << "nothing to see\n";
  EXPECT_THAT(
      describe_path(directory_),
      ElementsAre(directory_ + ": scene", "  " + path("images") + ": folder of 3 images", "    4x6: 1 image",
                  "    8x6: 2 images", "  " + path("map.pcd") + ": point cloud, 2 points",
                  "    dropped as not finite: 0",
                  "    extent: 4.00 x 2.00 x 1.50 m, from (0.00, -2.00, 0.00) to (4.00, 0.00, 1.50)",
                  "    attributes: intensity", "  " + path("model") + ": COLMAP model, 2 images, 1 camera, 0 points",
                  "    camera 7: PINHOLE 8x6, 2 images",
                  "    camera centres: 2.00 x 0.00 x 0.00 m, from (1.00, 0.00, 0.00) to (3.00, 0.00, 0.00)",
                  "  " + path("stamps.txt") + ": stamps of 2 images, 1.5 to 2 s", "  nothing is missing to refine it"));
}

TEST_F(InfoCommand, SaysWhatASceneLacks) {
  make_images();
  EXPECT_EQ(describe_path(directory_).back(), "  missing to refine it: a map (.pcd .ply .las), a COLMAP model");
}

TEST_F(InfoCommand, DescribesATrajectory) {
  std::ofstream(path("poses.txt")) << "1.5 0 0 0 0 0 0 1\n2.5 3 4 0 0 0 0 1\n";
  EXPECT_THAT(describe_path(path("poses.txt")),
              ElementsAre(path("poses.txt") + ": trajectory, 2 poses", "  stamps: 1.5 to 2.5 s, length 5.00 m",
                          "  extent: 3.00 x 4.00 x 0.00 m, from (0.00, 0.00, 0.00) to (3.00, 4.00, 0.00)"));
}

TEST_F(InfoCommand, RefusesWhatItDoesNotKnow) {
  std::ofstream(path("a.doc")) << "x";
  std::ofstream(path("a.txt")) << "x";
  for (const char* name : {"", "none", "a.doc", "a.txt"}) EXPECT_THROW(describe_path(path(name)), Error) << name;
}

}  // namespace
}  // namespace cpplus
