// Reads files that other programs wrote, and has them read ours. Each test is skipped where its program is missing.

#include <cstdlib>
#include <filesystem>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"
#include "known_cloud.h"

namespace cpplus {
namespace {

class InteropTest : public FileTest {
 protected:
  /// Runs a command in the test's folder, its output in log.txt; true when it ended with 0.
  bool run(const std::string& command) const {
    const std::string line = "cd '" + path("") + "' && QT_QPA_PLATFORM=offscreen " + command + " > log.txt 2>&1";
    return std::system(line.c_str()) == 0;
  }
};

constexpr int kNumPoints = 1000;
// Of the files beside this test, which are read where the programs are missing.
constexpr int kNumRecordedPoints = 24;

PointCloud known_cloud(int count, bool with_intensity, bool with_color) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    const auto xyz = interop::position(i);
    cloud.positions.emplace_back(xyz[0], xyz[1], xyz[2]);
    if (with_intensity) cloud.intensities.push_back(interop::intensity(i));
    if (with_color) cloud.colors.push_back(interop::color(i));
  }
  return cloud;
}

void expect_known(const PointCloud& cloud, int count, bool with_intensity, bool with_color) {
  const PointCloud expected = known_cloud(count, with_intensity, with_color);
  ASSERT_EQ(cloud.size(), expected.size());
  EXPECT_TRUE(cloud.origin.isZero());
  EXPECT_EQ(cloud.positions, expected.positions);
  EXPECT_EQ(cloud.intensities, expected.intensities);
  EXPECT_EQ(cloud.colors, expected.colors);
}

TEST(RecordedInteropTest, FilesOfPclOpen3dAndCloudCompare) {
  // What the tests below make, made once with 24 points: PCL 1.13, Open3D 0.16, CloudCompare 2.11.
  size_t num_files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(INTEROP_FILES_DIR)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().filename().string();
    SCOPED_TRACE(name);
    const bool is_cloudcompare = name.starts_with("cloudcompare");
    const bool has_intensity = is_cloudcompare || name.find("xyzi") != std::string::npos || name == "pcl_organised.pcd";
    const bool has_color = is_cloudcompare || name.starts_with("open3d") || name.find("rgb") != std::string::npos;
    expect_known(read_point_cloud(entry.path().string()), kNumRecordedPoints, has_intensity, has_color);
    ++num_files;
  }
  EXPECT_EQ(num_files, 20u);
}

TEST_F(InteropTest, FilesOfPcl) {
  const std::string tool = INTEROP_PCL_TOOL;
  if (tool.empty()) GTEST_SKIP() << "built without PCL (libpcl-dev)";
  ASSERT_TRUE(run(tool + " write . " + std::to_string(kNumPoints))) << read("log.txt");
  for (const std::string kind : {"xyz", "xyzi", "xyzrgb", "xyzrgba", "xyzinormal"}) {
    for (const std::string form : {"_ascii.pcd", "_binary.pcd", "_compressed.pcd", "_ascii.ply", "_binary.ply"}) {
      SCOPED_TRACE(kind + form);
      expect_known(read_point_cloud(path(kind + form)), kNumPoints, kind.find('i') != std::string::npos,
                   kind.find("rgb") != std::string::npos);
    }
  }
  ReadCounts counts;
  expect_known(read_point_cloud(path("organised.pcd"), &counts), kNumPoints, true, false);
  EXPECT_EQ(counts.dropped_non_finite, static_cast<size_t>(kNumPoints));
}

TEST_F(InteropTest, PclReadsOurFiles) {
  const std::string tool = INTEROP_PCL_TOOL;
  if (tool.empty()) GTEST_SKIP() << "built without PCL (libpcl-dev)";
  PointCloud cloud = known_cloud(kNumPoints, true, true);
  for (int i = 0; i < kNumPoints; ++i) {
    cloud.stamps_s.push_back(1.7e9 + 0.25 * i);
    cloud.num_views.push_back(static_cast<uint16_t>(i % 5));
  }
  write_point_cloud(path("ours.pcd"), cloud);
  ASSERT_TRUE(run(tool + " copy ours.pcd theirs.pcd")) << read("log.txt");
  const PointCloud back = read_point_cloud(path("theirs.pcd"));
  expect_known(back, kNumPoints, true, true);
  EXPECT_EQ(back.stamps_s, cloud.stamps_s);
  EXPECT_EQ(back.num_views, cloud.num_views);
}

TEST_F(InteropTest, FilesOfOpen3d) {
  const std::string tool = INTEROP_OPEN3D_TOOL;
  if (tool.empty()) GTEST_SKIP() << "built without Open3D (libopen3d-dev)";
  ASSERT_TRUE(run(tool + " write . " + std::to_string(kNumPoints))) << read("log.txt");
  for (const std::string name : {"ascii.pcd", "binary.pcd", "compressed.pcd", "ascii.ply", "binary.ply"}) {
    SCOPED_TRACE(name);
    expect_known(read_point_cloud(path(name)), kNumPoints, false, true);
  }
}

TEST_F(InteropTest, Open3dReadsOurFiles) {
  const std::string tool = INTEROP_OPEN3D_TOOL;
  if (tool.empty()) GTEST_SKIP() << "built without Open3D (libopen3d-dev)";
  for (const std::string extension : {".pcd", ".ply"}) {
    write_point_cloud(path("ours" + extension), known_cloud(kNumPoints, true, true));
    ASSERT_TRUE(run(tool + " copy ours" + extension + " theirs.ply")) << read("log.txt");
    SCOPED_TRACE(extension);
    expect_known(read_point_cloud(path("theirs.ply")), kNumPoints, false, true);
  }
}

TEST_F(InteropTest, CloudCompareBothWays) {
  // Debian's build knows PLY, but neither PCD nor LAS.
  if (!run("command -v CloudCompare")) GTEST_SKIP() << "CloudCompare is not installed";
  write_point_cloud(path("ours.ply"), known_cloud(kNumPoints, true, true));
  for (const std::string form : {"ASCII", "BINARY_LE", "BINARY_BE"}) {
    SCOPED_TRACE(form);
    ASSERT_TRUE(run("CloudCompare -SILENT -AUTO_SAVE OFF -O ours.ply -C_EXPORT_FMT PLY -PLY_EXPORT_FMT " + form +
                    " -SAVE_CLOUDS FILE theirs_" + form + ".ply"))
        << read("log.txt");
    expect_known(read_point_cloud(path("theirs_" + form + ".ply")), kNumPoints, true, true);
  }
}

TEST_F(InteropTest, ColmapConvertsOurModels) {
  if (!run("command -v colmap")) GTEST_SKIP() << "COLMAP is not installed";
  SparseModel model;
  model.cameras[2] = Camera(CameraModel::kOpenCv, 1024, 768, {667.1, 667.3, 514.7, 378.9, -0.1, 0.03, 7e-4, -5e-4});
  model.cameras[5] = Camera(CameraModel::kOpenCvFisheye, 640, 480, {300, 301, 319.5, 239.5, 0.01, 0.02, -0.003, 0.001});
  for (uint32_t i = 0; i < 3; ++i) {
    PosedImage image;
    image.id = i + 1;
    image.name = "sub/" + std::to_string(i) + ".jpg";
    image.camera_id = i == 0 ? 5 : 2;
    image.camera_from_map = Rigid3(Eigen::Quaterniond(1, 0.1 * i, -0.3, 0.7), Eigen::Vector3d(i / 3.0, 1e-7, -1e5 / 7));
    model.images.push_back(image);
  }
  SparsePoint point;
  point.id = 8;
  point.position = {1.0 / 3, 2, -7};
  point.color = {1, 2, 3};
  point.error_px = 0.25;
  point.track = {{1, {10, 20}}, {3, {30.5, 40.25}}};
  model.points.push_back(point);
  write_sparse_model_text(path("text"), model);
  std::filesystem::create_directories(path("binary"));
  std::filesystem::create_directories(path("back"));
  ASSERT_TRUE(run("colmap model_converter --input_path text --output_path binary --output_type BIN"))
      << read("log.txt");
  const SparseModel converted = read_sparse_model(path("binary"));
  write_sparse_model_binary(path("ours"), converted);
  ASSERT_TRUE(run("colmap model_converter --input_path ours --output_path back --output_type TXT")) << read("log.txt");
  const SparseModel back = read_sparse_model(path("back"));
  ASSERT_EQ(back.images.size(), 3u);
  for (const PosedImage& image : back.images) {
    const PosedImage& expected = model.images.at(image.id - 1);
    EXPECT_EQ(image.name, expected.name);
    EXPECT_EQ(image.camera_id, expected.camera_id);
    EXPECT_LT(rotation_angle_between(image.camera_from_map, expected.camera_from_map), 1e-12);
    EXPECT_LT((image.camera_from_map.translation - expected.camera_from_map.translation).norm(), 1e-9);
  }
  ASSERT_EQ(back.cameras.size(), 2u);
  for (const auto& [id, camera] : model.cameras) {
    EXPECT_EQ(back.cameras.at(id).model(), camera.model());
    for (size_t i = 0; i < camera.params().size(); ++i) {
      EXPECT_NEAR(back.cameras.at(id).params()[i], camera.params()[i], 1e-9);
    }
  }
  ASSERT_EQ(back.points.size(), 1u);
  EXPECT_EQ(back.points[0].color, point.color);
  ASSERT_EQ(back.points[0].track.size(), 2u);
  EXPECT_EQ(back.points[0].track[1].image_id, 3u);
  EXPECT_LT((back.points[0].track[1].pixel - Eigen::Vector2d(30.5, 40.25)).norm(), 1e-9);
}

}  // namespace
}  // namespace cpplus
