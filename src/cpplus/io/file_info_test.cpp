#include "cpplus/io/file_info.h"

#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using FileInfoTest = FileTest;

TEST_F(FileInfoTest, PointClouds) {
  PointCloud cloud;
  cloud.origin = {691235, 5334568, 0};
  cloud.positions = {Eigen::Vector3f(0, 1, 2), Eigen::Vector3f(-1, 5, 7)};
  cloud.intensities = {1, 2};
  for (const std::string name : {"a.pcd", "a.ply", "a.las"}) {
    write_point_cloud(path(name), cloud);
    const FileInfo info = inspect_file(path(name));
    EXPECT_EQ(info.kind, FileKind::kPointCloud);
    EXPECT_EQ(info.count, 2u);
    ASSERT_EQ(info.fields.size(), 4u);
    EXPECT_EQ(info.fields[3], "intensity");
    EXPECT_EQ(info.extent.has_value(), name == "a.las");
  }
  EXPECT_EQ(inspect_file(path("a.pcd")).format, "PCD binary");
  EXPECT_EQ(inspect_file(path("a.ply")).format, "PLY binary_little_endian");
  const FileInfo las = inspect_file(path("a.las"));
  EXPECT_EQ(las.format, "LAS 1.4, point format 0");
  EXPECT_LT((las.extent->min() - Eigen::Vector3d(691234, 5334569, 2)).norm(), 1e-8);
  EXPECT_LT((las.extent->max() - Eigen::Vector3d(691235, 5334573, 7)).norm(), 1e-8);
  EXPECT_ERROR(inspect_file(write("bad.pcd", "hello")), "bad.pcd: not a PCD file");
}

TEST_F(FileInfoTest, ModelsTrajectoriesStampsImagesAndFolders) {
  write("m/cameras.txt", "1 PINHOLE 640 480 500 500 320 240\n");
  write("m/images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n\n");
  const FileInfo model = inspect_file(path("m"));
  EXPECT_EQ(model.kind, FileKind::kSparseModel);
  EXPECT_EQ(model.count, 1u);
  EXPECT_THAT(model.cameras, testing::ElementsAre("1: PINHOLE 640 x 480"));

  const FileInfo trajectory = inspect_file(write("t.txt", "# TUM\n1 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n"));
  EXPECT_EQ(trajectory.kind, FileKind::kTrajectory);
  EXPECT_EQ(trajectory.count, 2u);
  EXPECT_EQ(trajectory.last_stamp_s, 3.0);

  const FileInfo stamps = inspect_file(write("s.txt", "b 1.jpg 9\na.jpg 5\n"));
  EXPECT_EQ(stamps.kind, FileKind::kStamps);
  EXPECT_EQ(stamps.first_stamp_s, 5.0);
  EXPECT_EQ(stamps.last_stamp_s, 9.0);

  write_png(path("f/sub/b.PNG"), ColorImage(7, 5));
  write_png(path("f/a.png"), ColorImage(7, 5));
  write("f/notes.md", "");
  const FileInfo image = inspect_file(path("f/a.png"));
  EXPECT_EQ(image.kind, FileKind::kImage);
  EXPECT_EQ(image.image_size.width, 7);
  EXPECT_EQ(image.image_size.height, 5);
  EXPECT_THAT(list_image_files(path("f")), testing::ElementsAre("a.png", "sub/b.PNG"));
  const FileInfo folder = inspect_file(path("f"));
  EXPECT_EQ(folder.kind, FileKind::kFolder);
  EXPECT_EQ(folder.count, 3u);
  EXPECT_EQ(folder.num_images, 2u);

  EXPECT_EQ(inspect_file(path("f/notes.md")).kind, FileKind::kUnknown);
  EXPECT_EQ(inspect_file(write("u.txt", "what is this\n")).kind, FileKind::kUnknown);
  EXPECT_ERROR(inspect_file(path("none")), "none: no such file or folder");
}

}  // namespace
}  // namespace cpplus
