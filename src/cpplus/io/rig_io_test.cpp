#include "cpplus/io/rig_io.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using RigFile = FileTest;

/// Looks forward from a LiDAR with x forward, y left, z up: a point 5 m ahead, 1 m left and 2 m up of it.
const Vector3d kInLidar(5, 1, 2);
const Vector3d kInCamera(-1, -2, 5);

const char* const kOwn =
    "cameras:\n"
    "  front:\n"
    "    model: OPENCV\n"
    "    width: 640\n"
    "    height: 480\n"
    "    params: [500, 501, 320, 240, -0.1, 0.02, 0.001, -0.002]\n"
    "    camera_from_lidar:\n"
    "      quaternion_wxyz: [0.5, 0.5, -0.5, 0.5]\n"
    "      translation: [0.1, 0.2, 0.3]\n"
    "    time_offset_s: -0.02\n"
    "    readout_s: 0.03\n";

TEST_F(RigFile, OwnFormat) {
  const Rig rig = read_rig(write("rig.yaml", kOwn), "");
  ASSERT_EQ(rig.cameras.size(), 1u);
  const RigCamera& camera = rig.cameras[0];
  EXPECT_EQ(rig.trajectory_frame, RigFrame::kLidar);
  EXPECT_EQ(camera.name, "front");
  EXPECT_EQ(camera.camera.params()[2], 319.5) << "COLMAP's pixels are half a pixel larger than ours";
  EXPECT_TRUE((*camera.camera_from_lidar * kInLidar).isApprox(kInCamera + Vector3d(0.1, 0.2, 0.3), 1e-12));
  EXPECT_FALSE(camera.camera_from_body);
  EXPECT_EQ(camera.time_offset_s, -0.02);
  EXPECT_EQ(camera.readout_s, 0.03);
}

TEST_F(RigFile, OwnFormatInOtherWords) {
  const std::string text =
      "trajectory_frame: body\n"
      "body_from_lidar: {matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 10]}\n"
      "cameras:\n"
      "  a: {model: PINHOLE, width: 64, height: 48, params: [60, 60, 32, 24], top_left_pixel: 0, images: a/,\n"
      "      camera_from_lidar: {quaternion_xyzw: [0.5, -0.5, 0.5, 0.5], translation: [0, 0, 0]}}\n"
      "  b: {intrinsics: info.yaml, images: b/,\n"
      "      camera_from_body: {matrix: [[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]]}}\n";
  write("info.yaml",
        "image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, data: [60, 0, 31, 0, 61, 23, 0, 0, 1]}\n"
        "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0.2]}\n");
  const Rig rig = read_rig(write("rig.yaml", text), "");
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.trajectory_frame, RigFrame::kBody);
  EXPECT_EQ(rig.cameras[0].camera.params()[2], 32.0);
  EXPECT_TRUE((*rig.cameras[0].camera_from_lidar * kInLidar).isApprox(kInCamera, 1e-12));
  EXPECT_TRUE((*rig.cameras[0].camera_from_body * (kInLidar + Vector3d(0, 0, 10))).isApprox(kInCamera, 1e-12));
  EXPECT_TRUE((*rig.cameras[1].camera_from_body * kInLidar).isApprox(kInCamera, 1e-12));
  EXPECT_EQ(rig.cameras[1].camera.model(), CameraModel::kFullOpenCv) << "k3 is not zero";
  EXPECT_EQ(rig.cameras[1].camera.params()[2], 31.0) << "OpenCV's pixels are ours";
}

TEST_F(RigFile, WrittenRigComesBack) {
  const Rig rig = read_rig(write("rig.yaml", kOwn), "");
  write_rig(path("again.yaml"), rig);
  const Rig again = read_rig(path("again.yaml"), "");
  ASSERT_EQ(again.cameras.size(), 1u);
  EXPECT_EQ(again.cameras[0].camera.params(), rig.cameras[0].camera.params());
  EXPECT_EQ(again.cameras[0].camera_from_lidar->translation, rig.cameras[0].camera_from_lidar->translation);
  EXPECT_LT(rotation_angle_between(*again.cameras[0].camera_from_lidar, *rig.cameras[0].camera_from_lidar), 1e-15);
  EXPECT_EQ(again.cameras[0].time_offset_s, -0.02);
  EXPECT_EQ(again.cameras[0].readout_s, 0.03);
}

TEST_F(RigFile, KalibrGivesCameraFromImuAndTheShiftOfItsClock) {
  const Rig rig = read_rig(
      write("camchain.yaml",
            "cam0:\n  camera_model: pinhole\n  intrinsics: [461, 460, 362, 246]\n  distortion_model: radtan\n"
            "  distortion_coeffs: [-0.27, 0.06, 0.0008, 0.0001]\n  resolution: [752, 480]\n"
            "  timeshift_cam_imu: -0.005\n"
            "  T_cam_imu:\n  - [0, -1, 0, 0.1]\n  - [0, 0, -1, 0]\n  - [1, 0, 0, 0]\n  - [0, 0, 0, 1]\n"
            "cam1:\n  camera_model: pinhole\n  intrinsics: [461, 460, 362, 246]\n  distortion_model: equidistant\n"
            "  distortion_coeffs: [-0.01, 0.02, 0, 0]\n  resolution: [752, 480]\n"
            "  T_cn_cnm1:\n  - [1, 0, 0, -0.2]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n"),
      "");
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.trajectory_frame, RigFrame::kBody);
  EXPECT_TRUE((*rig.cameras[0].camera_from_body * kInLidar).isApprox(kInCamera + Vector3d(0.1, 0, 0), 1e-12));
  EXPECT_TRUE((*rig.cameras[1].camera_from_body * kInLidar).isApprox(kInCamera + Vector3d(-0.1, 0, 0), 1e-12));
  EXPECT_EQ(rig.cameras[0].time_offset_s, -0.005);
  EXPECT_EQ(rig.cameras[1].image_prefix, "cam1/") << "several cameras have a folder each";
  EXPECT_EQ(rig.cameras[0].camera.params()[2], 362);
  EXPECT_EQ(rig.cameras[1].camera.model(), CameraModel::kOpenCvFisheye);
}

TEST_F(RigFile, R3LiveGivesTheCameraInTheImu) {
  const Rig rig =
      read_rig(write("r3live.yaml",
                     "r3live_vio:\n  image_width: 1280\n  image_height: 1024\n"
                     "  camera_intrinsic:\n    [863.4, 0.0, 640.6,\n    0.0, 863.5, 518.3,\n    0.0, 0.0, 1.0 ]\n"
                     "  camera_dist_coeffs: [-0.1, 0.1, -1.2872e-04, 5.7923e-05, -0.02]\n"
                     "  camera_ext_R:\n    [0, 0, 1,\n    -1, 0, 0,\n    0, -1, 0]\n  camera_ext_t: [0.5, 0, 0]\n"),
               "");
  ASSERT_EQ(rig.cameras.size(), 1u);
  EXPECT_EQ(rig.trajectory_frame, RigFrame::kBody);
  EXPECT_TRUE((*rig.cameras[0].camera_from_body * kInLidar).isApprox(kInCamera - Vector3d(0, 0, 0.5), 1e-12))
      << "the camera stands half a metre before the IMU";
  EXPECT_EQ(rig.cameras[0].camera.model(), CameraModel::kFullOpenCv);
  EXPECT_EQ(rig.cameras[0].camera.params()[8], -0.02) << "k3 is the fifth coefficient";
}

const char* const kFastLivo2 =
    "extrin_calib:\n  extrinsic_T: [0.04, 0.02, -0.03]\n  extrinsic_R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
    "  Rcl: [0, -1, 0, 0, 0, -1, 1, 0, 0]\n  Pcl: [0.1, 0.2, 0.3]\n"
    "time_offset:\n  img_time_offset: 0.1\n  exposure_time_init: 0.005\n";

TEST_F(RigFile, FastLivo2GivesCameraFromLidarAndLidarInTheImu) {
  const std::string camera = write("camera.yaml",
                                   "cam_model: Pinhole\ncam_width: 1280\ncam_height: 1024\nscale: 0.5\ncam_fx: 1293.5\n"
                                   "cam_fy: 1293.3\ncam_cx: 626.9\ncam_cy: 522.8\ncam_d0: -0.07\ncam_d1: 0.12\n"
                                   "cam_d2: -0.001\ncam_d3: 0.0002\n");
  const std::string file = write("avia.yaml", kFastLivo2);
  const Rig rig = read_rig(file, camera);
  ASSERT_EQ(rig.cameras.size(), 1u);
  EXPECT_EQ(rig.trajectory_frame, RigFrame::kBody);
  EXPECT_TRUE((*rig.cameras[0].camera_from_lidar * kInLidar).isApprox(kInCamera + Vector3d(0.1, 0.2, 0.3), 1e-12));
  const Vector3d in_imu = kInLidar + Vector3d(0.04, 0.02, -0.03);
  EXPECT_TRUE((*rig.cameras[0].camera_from_body * in_imu).isApprox(kInCamera + Vector3d(0.1, 0.2, 0.3), 1e-12));
  EXPECT_NEAR(rig.cameras[0].time_offset_s, 0.105, 1e-15);
  EXPECT_EQ(rig.cameras[0].camera.params()[5], 0.12);
  EXPECT_ERROR(read_rig(file, ""), "avia.yaml: holds no camera");

  std::string nested =
      "/node:\n  ros__parameters:\n    camera: {model: EquidistantCamera, width: 720, height: 540, fx: 351, "
      "fy: 352, cx: 367, cy: 253, k1: -0.03, k2: 0, k3: 0, k4: 0}\n";
  std::istringstream lines(kFastLivo2);
  for (std::string line; std::getline(lines, line);) nested += "    " + line + "\n";
  const Rig ros2 = read_rig(write("ros2.yaml", nested), "");
  EXPECT_EQ(ros2.cameras[0].camera.model(), CameraModel::kOpenCvFisheye);
  EXPECT_TRUE((*ros2.cameras[0].camera_from_body * in_imu).isApprox(kInCamera + Vector3d(0.1, 0.2, 0.3), 1e-12));
}

TEST_F(RigFile, BadFilesAreErrorsThatNameTheKey) {
  const auto replaced = [](const std::string& from, const std::string& to) {
    std::string text = kOwn;
    return text.replace(text.find(from), from.size(), to);
  };
  const auto expect = [&](const std::string& text, const std::string& message) {
    EXPECT_ERROR(read_rig(write("rig.yaml", text), ""), message);
  };
  EXPECT_ERROR(read_rig(path("none.yaml"), ""), "none.yaml: cannot be read");
  expect("a: [\n", "rig.yaml: line 2: ");
  expect("a: 1\n", "rig.yaml: not a rig: none of the keys cameras");
  expect("camera_matrix: 1\n", "rig.yaml: a camera_info file has no extrinsic");
  expect("cameras: 3\n", "rig.yaml: cameras must be a group");
  expect(replaced("readout_s: 0.03", "readout: 0.03"), "cameras.front: unknown key 'readout'");
  expect(replaced("OPENCV", "OPENCVS"), "cameras.front: unknown camera model 'OPENCVS'");
  expect(replaced("500, 501,", "500,"), "cameras.front: camera OPENCV: expected 8 parameters");
  expect(replaced("width: 640", "width: wide"), "cameras.front.width: not a finite number: 'wide'");
  expect(replaced("[0.5, 0.5, -0.5, 0.5]", "[1, 0.5, -0.5, 0.5]"),
         "camera_from_lidar: the quaternion has length 1.32288");
  expect(replaced("quaternion_wxyz", "quaternion"), "camera_from_lidar: unknown key 'quaternion'");
  expect(replaced("[0.1, 0.2, 0.3]", "[0.1, 0.2]"), "4 and 2 numbers instead of");
}

}  // namespace
}  // namespace cpplus
