#include "cpplus/io/pose_file.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using PoseFile = FileTest;

/// A quarter turn about z: the sensor's x axis is the map's y axis.
void expect_quarter_turn(const StampedPose& pose, double stamp_s) {
  EXPECT_NEAR(pose.stamp_s, stamp_s, 1e-6);
  EXPECT_TRUE((pose.map_from_sensor * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3), 1e-6))
      << (pose.map_from_sensor * Eigen::Vector3d(1, 0, 0)).transpose();
}

TEST_F(PoseFile, Tum) {
  const auto poses = read_pose_file(
      write("t.txt", "# stamp ...\n2.5 1 2 3 0 0 0.70710678 0.70710678\n1.5 1 2 3 0 0 0 1 # earlier\n"), "");
  ASSERT_EQ(poses.size(), 2u);
  expect_quarter_turn(poses[0], 2.5);
  EXPECT_EQ(poses[1].stamp_s, 1.5) << "the order of the file is kept";
}

TEST_F(PoseFile, KittiWithTimes) {
  const std::string path = write("poses.txt", "0 -1 0 1 1 0 0 2 0 0 1 3\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  const auto poses = read_pose_file(path, write("times.txt", "1.0e+01\n1.01e+01\n"));
  ASSERT_EQ(poses.size(), 2u);
  expect_quarter_turn(poses[0], 10.0);
  EXPECT_EQ(poses[1].stamp_s, 10.1);
  EXPECT_ERROR(read_pose_file(path, ""), "poses.txt: KITTI poses have no stamps");
  EXPECT_ERROR(read_pose_file(path, write("short.txt", "1\n")), "short.txt: 1 stamps for the 2 poses of");
}

TEST_F(PoseFile, CsvGoesByItsHeader) {
  const auto euroc = read_pose_file(
      write("data.csv",
            "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
            "v_RS_R_x [m s^-1]\n1403636579250000000, 1, 2, 3, 0.70710678, 0, 0, 0.70710678, 9\n"),
      "");
  ASSERT_EQ(euroc.size(), 1u);
  expect_quarter_turn(euroc[0], 1403636579.25);
  const auto ros = read_pose_file(
      write("odom.csv",
            "time,field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.position.z,"
            "field.pose.pose.orientation.x,field.pose.pose.orientation.y,field.pose.pose.orientation.z,"
            "field.pose.pose.orientation.w,field.twist.twist.linear.x\n12.5,1,2,3,0,0,0.70710678,0.70710678,9\n"),
      "");
  expect_quarter_turn(ros[0], 12.5);
  const auto named =
      read_pose_file(write("n.csv", "qw,qx,qy,qz,x,y,z,time_ns\n0.70710678,0,0,0.70710678,1,2,3,2500000000\n"), "");
  expect_quarter_turn(named[0], 2.5);
}

TEST_F(PoseFile, BadLinesAreErrorsThatNameThem) {
  const auto expect = [&](const std::string& text, const std::string& message) {
    EXPECT_ERROR(read_pose_file(write("t.txt", text), ""), message);
  };
  expect("", "t.txt: holds no poses");
  expect("x,y,z\n", "t.txt:1: its header names no column for stamp");
  expect("1,0,0,0,0,0,0,1\n", "t.txt:1: its header names no column for stamp");
  expect("t,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,0\n", "t.txt:2: 7 values instead of the header's 8");
  expect("t,x,y,z,qx,qy,qz,qw\nnow,0,0,0,0,0,0,1\n", "t.txt:2: not a stamp: 'now'");
  expect("1 0 0 0 0 0 0\n", "t.txt:1: 7 values, neither the 8");
  expect("1 0 0 0 0 0 0 1\n1 0 0 0 0 1 0 0 0 0 1 0\n", "t.txt:2: 12 values, neither the 8");
  expect("1 0 0 0 0 0 0 2\n", "t.txt:1: the quaternion has length 2, not 1");
  expect("1 0 0 inf 0 0 0 1\n", "t.txt:1: not a finite number: 'inf'");
  expect("1 0 0 0 0 1 0 0 0 0 -1 0\n", "t.txt:1: not a rotation matrix but a reflection");
  expect("2 0 0 0 0 1 0 0 0 0 1 0\n", "t.txt:1: not a rotation matrix: it stretches by 1 to 2");
}

}  // namespace
}  // namespace cpplus
