#include <fmt/format.h>

#include "cpplus/io/image_io.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_bag.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

using testing_bag::BagBuilder;
using testing_bag::header;
using testing_bag::image;
using testing_bag::odometry;
using testing_bag::text;

std::string point_cloud(double stamp_s, const std::string& frame) {
  const auto point_field = [](const std::string& name, uint32_t offset) {
    return text(name) + bytes_of(offset) + bytes_of(uint8_t{7}) + bytes_of(uint32_t{1});
  };
  std::string points;
  for (const float value : {5.0f, 1.0f, 2.0f, 9.0f, 0.0f, 0.0f, 0.0f, 9.0f}) points += bytes_of(value);
  return header(stamp_s, frame) + bytes_of(uint32_t{1}) + bytes_of(uint32_t{2}) + bytes_of(uint32_t{4}) +
         point_field("x", 0) + point_field("y", 4) + point_field("z", 8) + point_field("intensity", 12) +
         std::string(1, '\0') + bytes_of(uint32_t{16}) + bytes_of(uint32_t{32}) + text(points) + std::string(1, '\1');
}

std::string livox(double stamp_s) {
  std::string message = header(stamp_s, "livox") + bytes_of(uint64_t{12500000000}) + bytes_of(uint32_t{1}) +
                        std::string(4, '\0') + bytes_of(uint32_t{1});
  message += bytes_of(uint32_t{50000000});
  for (const float value : {5.0f, 1.0f, 2.0f}) message += bytes_of(value);
  return message + "\x64" + std::string(2, '\0');
}

std::string camera_info() {
  std::string message =
      header(1.0, "camera") + bytes_of(uint32_t{1}) + bytes_of(uint32_t{2}) + text("plumb_bob") + bytes_of(uint32_t{5});
  for (const double value : {0.1, 0.0, 0.0, 0.0, 0.0, 30.0, 0.0, 1.5, 0.0, 31.0, 0.5, 0.0, 0.0, 1.0})
    message += bytes_of(value);
  return message;
}

using Rosbag = FileTest;

TEST_F(Rosbag, ImagesScansAndPosesComeOut) {
  BagBuilder bag;
  for (int i = 0; i < 4; ++i) bag.add("/odom", "nav_msgs/Odometry", odometry(12.0 + 0.1 * i, i));
  bag.add("/camera", "sensor_msgs/Image", image(12.125, "bgr8", std::string("\x03\x02\x01\x06\x05\x04", 6)));
  bag.add("/camera/info", "sensor_msgs/CameraInfo", camera_info());
  bag.add("/points", "sensor_msgs/PointCloud2", point_cloud(12.1, "lidar"));
  bag.add("/points", "sensor_msgs/PointCloud2", point_cloud(19.0, "lidar"));
  const ImportedProject project = import_rosbag(write("a.bag", bag.bytes()), {}, path("out"));
  ASSERT_EQ(project.images.size(), 1u);
  EXPECT_EQ(project.images[0].name, "12.125000.png");
  EXPECT_EQ(project.stamps_s.at("12.125000.png"), 12.125);
  const ColorImage pixels = read_color_image(project.images[0].path);
  EXPECT_EQ(pixels.at(0, 0), (Rgb{1, 2, 3}));
  EXPECT_EQ(pixels.at(1, 0), (Rgb{4, 5, 6}));
  ASSERT_EQ(project.trajectory.size(), 4u);
  const Vector3d moved = project.trajectory[1].map_from_sensor * Vector3d(1, 0, 0);
  EXPECT_LT((moved - Vector3d(1, 3, 3)).norm(), 1e-9) << moved.transpose();
  ASSERT_EQ(project.scans.size(), 1u);
  EXPECT_LT((project.scan_poses[0].map_from_sensor.translation - Vector3d(1, 2, 3)).norm(), 1e-9);
  const PointCloud scan = read_point_cloud(project.scans[0].path);
  ASSERT_EQ(scan.size(), 1u) << "a point at the origin is no return";
  EXPECT_EQ(scan.point(0), Vector3d(5, 1, 2));
  EXPECT_EQ(scan.intensities[0], 9.0f);
  EXPECT_THAT(project.notes, testing::ElementsAre(testing::HasSubstr("1 of 2 scans outside the poses, left out")));
  EXPECT_FALSE(std::filesystem::exists(path("out/scans/19.000000.pcd")));
  ASSERT_EQ(project.rig->cameras.size(), 1u);
  EXPECT_EQ(project.rig->cameras[0].camera.params(), (std::vector<double>{30, 31, 1.5, 0.5, 0.1, 0, 0, 0}));
  EXPECT_FALSE(project.rig->cameras[0].camera_from_lidar);
}

/// parent_from_child as tf gives it: translation, then quaternion with w last.
std::string transform(const std::string& parent, const std::string& child, const std::vector<double>& values) {
  std::string message = header(0.0, parent) + text(child);
  for (const double value : values) message += bytes_of(value);
  return message;
}

TEST_F(Rosbag, ExtrinsicsComeFromTheStaticTransforms) {
  BagBuilder bag;
  for (int i = 0; i < 4; ++i) bag.add("/odom", "nav_msgs/Odometry", odometry(12.0 + 0.1 * i, i));
  bag.add("/camera/image", "sensor_msgs/Image", image(12.125, "mono8", "ab"));
  bag.add("/camera/camera_info", "sensor_msgs/CameraInfo", camera_info());
  bag.add("/other/camera_info", "sensor_msgs/CameraInfo", camera_info());
  bag.add("/points", "sensor_msgs/PointCloud2", point_cloud(12.1, "lidar"));
  // The LiDAR stands 1 m above the base; the camera looks along the base's x axis, 0.5 m ahead of it.
  bag.add("/tf_static", "tf2_msgs/TFMessage",
          bytes_of(uint32_t{2}) + transform("base", "lidar", {0, 0, 1, 0, 0, 0, 1}) +
              transform("/base", "camera", {0.5, 0, 0, -0.5, 0.5, -0.5, 0.5}));
  const ImportedProject project = import_rosbag(write("a.bag", bag.bytes()), {}, path("out"));
  ASSERT_EQ(project.rig->cameras.size(), 1u) << "of the other camera there are no images";
  const RigCamera& camera = project.rig->cameras[0];
  EXPECT_EQ(camera.name, "camera_camera_info");
  EXPECT_EQ(project.rig->trajectory_frame, RigFrame::kBody);
  const Vector3d of_body = camera.camera_from_body.value() * Vector3d(5.5, 1, 2);
  EXPECT_LT((of_body - Vector3d(-1, -2, 5)).norm(), 1e-12) << of_body.transpose();
  const Vector3d of_lidar = camera.camera_from_lidar.value() * Vector3d(5.5, 1, 1);
  EXPECT_LT((of_lidar - Vector3d(-1, -2, 5)).norm(), 1e-12) << of_lidar.transpose();
  ASSERT_EQ(project.scan_poses.size(), 1u);
  EXPECT_LT((project.scan_poses[0].map_from_sensor.translation - Vector3d(1, 2, 4)).norm(), 1e-9);
  EXPECT_LT((project.trajectory[1].map_from_sensor.translation - Vector3d(1, 2, 3)).norm(), 1e-9);
}

TEST_F(Rosbag, CompressedImagesLivoxAndPath) {
  write_png(path("a.png"), ColorImage(2, 1));
  BagBuilder bag;
  const auto pose = [](double stamp_s) {
    return header(stamp_s, "map") + odometry(stamp_s, 1).substr(4 + 8 + 4 + 3 + 4 + 4, 56);
  };
  bag.add("/path", "nav_msgs/Path", header(12.0, "map") + bytes_of(uint32_t{1}) + pose(12.0));
  bag.add("/path", "nav_msgs/Path", header(13.0, "map") + bytes_of(uint32_t{2}) + pose(12.3) + pose(12.7));
  bag.add("/left", "sensor_msgs/CompressedImage", header(12.5, "camera") + text("png") + text(read("a.png")));
  bag.add("/right", "sensor_msgs/CompressedImage", header(12.5, "camera") + text("webp") + text("RIFF"));
  bag.add("/livox/lidar", "livox_ros_driver2/CustomMsg", livox(12.5));
  const ImportedProject project = import_rosbag(write("a.bag", bag.bytes()), {}, path("out"));
  ASSERT_EQ(project.images.size(), 1u);
  EXPECT_EQ(project.images[0].name, "left/12.500000.png") << "topics have a folder each";
  EXPECT_EQ(read_image_size(project.images[0].path).width, 2);
  ASSERT_EQ(project.trajectory.size(), 2u) << "the last path";
  EXPECT_EQ(project.trajectory[0].stamp_s, 12.3);
  ASSERT_EQ(project.scans.size(), 1u);
  const PointCloud scan = read_point_cloud(project.scans[0].path);
  EXPECT_EQ(scan.point(0), Vector3d(5, 1, 2));
  EXPECT_EQ(scan.intensities[0], 100.0f);
  EXPECT_EQ(scan.stamps_s[0], 12.55);
  EXPECT_THAT(
      project.notes,
      testing::ElementsAre(testing::HasSubstr("of /right left out: 1, the first: " + path("a.bag") +
                                              ": /right: a compressed image that is neither JPEG nor PNG: 'webp'")));
}

TEST_F(Rosbag, CloudsInTheFrameOfThePosesAreNoScans) {
  BagBuilder bag;
  for (int i = 0; i < 4; ++i) bag.add("/odom", "nav_msgs/Odometry", odometry(12.0 + 0.1 * i, i));
  bag.add("/cloud_registered", "sensor_msgs/PointCloud2", point_cloud(12.1, "map"));
  const ImportedProject project = import_rosbag(write("a.bag", bag.bytes()), {}, path("out"));
  EXPECT_TRUE(project.scans.empty());
  EXPECT_THAT(project.notes,
              testing::ElementsAre(testing::HasSubstr("/cloud_registered are in the frame map of the poses already")));
}

TEST_F(Rosbag, Lz4ChunksAreDecoded) {
  BagBuilder bag;
  for (int i = 0; i < 4; ++i) bag.add("/odom", "nav_msgs/Odometry", odometry(12.0 + 0.1 * i, i));
  const ImportedProject plain = import_rosbag(write("a.bag", bag.bytes()), {}, path("out"));
  const ImportedProject packed = import_rosbag(write("b.bag", bag.lz4_bytes()), {}, path("out"));
  ASSERT_EQ(packed.trajectory.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(packed.trajectory[i].map_from_sensor.translation, plain.trajectory[i].map_from_sensor.translation);
  }
}

TEST_F(Rosbag, SeveralTopicsNeedAChoice) {
  BagBuilder bag;
  bag.add("/odom", "nav_msgs/Odometry", odometry(12.0, 0));
  bag.add("/odom_wheels", "nav_msgs/Odometry", odometry(12.0, 5));
  write("a.bag", bag.bytes());
  const ImportedProject none = import_rosbag(path("a.bag"), {}, path("out"));
  EXPECT_TRUE(none.trajectory.empty());
  EXPECT_THAT(none.notes,
              testing::ElementsAre(testing::HasSubstr("2 topics of poses, none taken: /odom, /odom_wheels")));
  RosbagTopics topics;
  topics.poses = "/odom_wheels";
  EXPECT_EQ(import_rosbag(path("a.bag"), topics, path("out")).trajectory[0].map_from_sensor.translation.x(), 5.0);
  topics.poses = "/odometry";
  EXPECT_ERROR(import_rosbag(path("a.bag"), topics, path("out")), "a.bag: has no topic /odometry");
}

TEST_F(Rosbag, BadBagsAreNamed) {
  BagBuilder bag;
  bag.add("/odom", "nav_msgs/Odometry", odometry(12.0, 0));
  const auto expect = [&](const std::string& bytes, const std::string& message) {
    EXPECT_ERROR(import_rosbag(write("a.bag", bytes), {}, path("out")), message);
  };
  expect("#ROSBAG V1.2\n", "a.bag: not a ROS 1 bag of format 2.0");
  expect("SQLite format 3", "a.bag: not a ROS 1 bag of format 2.0");
  expect(bag.bytes("bz2"), "a.bag: its chunks are compressed (bz2)");
  expect(bag.bytes("lz4"), "a.bag: its LZ4 data do not begin as a frame does");
  expect(bag.bytes().substr(0, 400), "a.bag: truncated: ");
  expect("#ROSBAG V2.0\n" + text(text("op")) + text(""), "a.bag: a record's header is broken");
  expect("#ROSBAG V2.0\n" + text("ab") + text(""), "a.bag: a record's header is broken");
  BagBuilder broken;
  broken.add("/odom", "nav_msgs/Odometry", odometry(12.0, 0).substr(0, 40));
  EXPECT_THAT(import_rosbag(write("a.bag", broken.bytes()), {}, path("out")).notes,
              testing::ElementsAre(testing::HasSubstr("/odom: the message is broken off")));
}

}  // namespace
}  // namespace cpplus
