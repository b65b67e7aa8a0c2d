#include "cpplus/io/nerfstudio_io.h"

#include <nlohmann/json.hpp>

#include "cpplus/io/image_io.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using NerfstudioWriterTest = FileTest;
using Json = nlohmann::json;

const Camera kCamera(CameraModel::kPinhole, 64, 48, {50, 55, 31.5, 20});

Json matrix(const std::vector<std::vector<double>>& rows) { return rows; }

TEST_F(NerfstudioWriterTest, AxesAreThoseOfOpenGl) {
  // The camera stands at (1, 2, 3) and looks along the map's y axis, its right is the map's x, its down is -z: in the
  // file y is up (the map's z) and z is backward (the map's -y).
  Eigen::Matrix3d map_from_camera;
  map_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Rigid3 camera_from_map = inverse(Rigid3(map_from_camera, Eigen::Vector3d(1, 2, 3)));
  write_nerfstudio(path("transforms.json"), {{"images/a.png", "depths/a.png", kCamera, camera_from_map}}, "points.ply");
  const Json root = Json::parse(read("transforms.json"));
  const Json expected = matrix({{1, 0, 0, 1}, {0, 0, -1, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}});
  const Json& written = root["frames"][0]["transform_matrix"];
  for (size_t i = 0; i < 4; ++i) {
    for (size_t j = 0; j < 4; ++j) EXPECT_NEAR(written[i][j].get<double>(), expected[i][j].get<double>(), 1e-12);
  }
  EXPECT_EQ(root["ply_file_path"], "points.ply");
  EXPECT_EQ(root["frames"][0]["file_path"], "images/a.png");
  EXPECT_EQ(root["frames"][0]["depth_file_path"], "depths/a.png");
}

TEST_F(NerfstudioWriterTest, PixelsAreThoseOfColmap) {
  write_nerfstudio(path("transforms.json"), {{"images/a.png", "", kCamera, {}}}, "");
  const Json root = Json::parse(read("transforms.json"));
  EXPECT_EQ(root["camera_model"], "PINHOLE");
  EXPECT_EQ(root["w"], 64);
  EXPECT_EQ(root["h"], 48);
  EXPECT_EQ(root["fl_x"], 50);
  EXPECT_EQ(root["fl_y"], 55);
  EXPECT_EQ(root["cx"], 32);  // the middle of the image: our 31.5
  EXPECT_EQ(root["cy"], 20.5);
  EXPECT_FALSE(root.contains("ply_file_path"));
  EXPECT_FALSE(root["frames"][0].contains("depth_file_path"));
}

TEST_F(NerfstudioWriterTest, CamerasThatDifferStandInTheFrames) {
  const Camera other(CameraModel::kPinhole, 32, 24, {25, 25, 16, 12});
  write_nerfstudio(path("transforms.json"), {{"a.png", "", kCamera, {}}, {"b.png", "", other, {}}}, "");
  const Json root = Json::parse(read("transforms.json"));
  EXPECT_FALSE(root.contains("fl_x"));
  EXPECT_EQ(root["frames"][0]["fl_x"], 50);
  EXPECT_EQ(root["frames"][1]["fl_x"], 25);
  EXPECT_EQ(root["frames"][1]["w"], 32);
}

TEST_F(NerfstudioWriterTest, ComesBackThroughTheImporter) {
  std::vector<NerfstudioFrame> frames;
  for (const char* name : {"images/a.png", "images/b.png"}) {
    write_png(path(name), ColorImage(64, 48));
    const double i = static_cast<double>(frames.size());
    frames.push_back({name, "", kCamera, Rigid3(Eigen::Quaterniond(0.5, i, 0.3, -0.2), Eigen::Vector3d(1, i, -2))});
  }
  write_nerfstudio(path("transforms.json"), frames, "");
  const ImportedProject project = import_nerfstudio(path("transforms.json"));
  ASSERT_TRUE(project.model);
  ASSERT_EQ(project.model->images.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const Rigid3& back = project.model->images[i].camera_from_map;
    EXPECT_LT(rotation_angle_between(back, frames[i].camera_from_map), 1e-7);
    EXPECT_LT((back.translation - frames[i].camera_from_map.translation).norm(), 1e-12);
  }
  EXPECT_EQ(project.model->cameras.begin()->second.params(), kCamera.params());
}

TEST_F(NerfstudioWriterTest, TakesPinholeCamerasOnly) {
  const Camera fisheye(CameraModel::kOpenCvFisheye, 64, 48, {50, 50, 32, 24, 0, 0, 0, 0});
  EXPECT_ERROR(write_nerfstudio(path("t.json"), {{"a.png", "", fisheye, {}}}, ""), "OPENCV_FISHEYE");
  EXPECT_EQ(num_files(), 0u);
}

}  // namespace
}  // namespace cpplus
