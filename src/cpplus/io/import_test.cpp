#include <fmt/format.h>

#include <cmath>

#include "cpplus/io/image_io.h"
#include "cpplus/io/imported_project.h"
#include "cpplus/io/kitti_scan.h"
#include "cpplus/io/pcd_columns.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

class Import : public FileTest {
 protected:
  void write_image(const std::string& name, int width = 32, int height = 24) const {
    write(name, "");  // makes the folder
    write_png(path(name), ColorImage(width, height));
  }

  /// Where the point of the map is seen.
  static Vector3d in_camera(const ImportedProject& project, const std::string& image, const Vector3d& x_in_map) {
    for (const PosedImage& posed : project.model->images) {
      if (posed.name == image) return posed.camera_from_map * x_in_map;
    }
    ADD_FAILURE() << "no pose of " << image;
    return Vector3d::Zero();
  }

  static void expect_near(const Vector3d& actual, const Vector3d& expected) {
    EXPECT_LT((actual - expected).norm(), 1e-6) << actual.transpose() << " instead of " << expected.transpose();
  }
};

TEST_F(Import, ColmapStaysAsItIs) {
  write_image("images/left/a.png");
  write("sparse/0/cameras.txt", "1 PINHOLE 32 24 30 30 16 12\n");
  write("sparse/0/images.txt", "1 1 0 0 0 0 0 -2 1 left/a.png\n\n");
  write("map.ply", "");
  write("stamps.txt", "left/a.png 12.5\n");
  const ImportedProject project = import_colmap(path(""));
  ASSERT_EQ(project.images.size(), 1u);
  EXPECT_EQ(project.images[0].name, "left/a.png");
  EXPECT_EQ(project.map, path("map.ply"));
  EXPECT_EQ(project.stamps_s.at("left/a.png"), 12.5);
  EXPECT_EQ(project.model->cameras.at(1).params()[2], 15.5);
  expect_near(in_camera(project, "left/a.png", Vector3d(1, 0, 5)), Vector3d(1, 0, 3));
  EXPECT_ERROR(import_colmap(path("images")), "images: no COLMAP model in it, in sparse/0 or in sparse");
}

/// The camera stands at (1, 2, 3), upright in a map with z up, and looks along the map's y axis: its x axis (right) is
/// the map's, OpenGL's y (up) is the map's z, OpenGL's z (backward) the map's -y.
const char* const kNerfFrame = "\"transform_matrix\": [[1, 0, 0, 1], [0, 0, -1, 2], [0, 1, 0, 3], [0, 0, 0, 1]]";

TEST_F(Import, NerfstudioCamerasAreOpenGls) {
  write_image("images/left/a.png");
  write_image("images/b.png", 16, 12);
  write("cloud.ply", "");
  write("transforms.json",
        fmt::format(
            "{{\"w\": 32, \"h\": 24, \"fl_x\": 30, \"fl_y\": 31, \"cx\": 16, \"cy\": 12, \"k1\": 0.1, \"p2\": 0.01, "
            "\"ply_file_path\": \"cloud.ply\", \"frames\": [{{\"file_path\": \"./images/left/a.png\", {0}}}, "
            "{{\"file_path\": \"images/b\", \"w\": 16, \"h\": 12, \"fl_x\": 15, \"fl_y\": 15, \"cx\": 8, \"cy\": 6, "
            "\"k1\": 0, \"p2\": 0, {0}}}, {{\"file_path\": \"images/gone.png\", {0}}}]}}",
            kNerfFrame));
  const ImportedProject project = import_nerfstudio(path(""));
  // A point 5 m ahead, 1 m to the right and 2 m above the camera.
  expect_near(in_camera(project, "left/a.png", Vector3d(2, 7, 5)), Vector3d(1, -2, 5));
  expect_near(in_camera(project, "b.png", Vector3d(2, 7, 5)), Vector3d(1, -2, 5));
  ASSERT_EQ(project.model->cameras.size(), 2u);
  const Camera& first = project.model->cameras.at(1);
  EXPECT_EQ(first.model(), CameraModel::kOpenCv);
  EXPECT_EQ(first.params(), (std::vector<double>{30, 31, 15.5, 11.5, 0.1, 0, 0, 0.01}));
  EXPECT_EQ(project.model->cameras.at(2).model(), CameraModel::kPinhole);
  EXPECT_EQ(project.map, path("cloud.ply"));
  EXPECT_EQ(project.images.size(), 2u);
  ASSERT_EQ(project.notes.size(), 1u);
  EXPECT_THAT(project.notes[0], testing::HasSubstr("1 of 3 images missing"));
}

TEST_F(Import, BlenderGivesAnAngleOfView) {
  write_image("train/r_0.png");
  write("transforms.json",
        fmt::format("{{\"camera_angle_x\": {}, \"frames\": [{{\"file_path\": \"./train/r_0\", {}}}]}}",
                    2.0 * std::atan(16.0 / 30.0), kNerfFrame));
  const ImportedProject project = import_nerfstudio(path("transforms.json"));
  const Camera& camera = project.model->cameras.at(1);
  EXPECT_NEAR(camera.params()[0], 30.0, 1e-12);
  EXPECT_EQ(camera.params()[2], 15.5);
  EXPECT_EQ(project.images[0].name, "train/r_0.png");
}

TEST_F(Import, BadNerfstudioFilesAreNamed) {
  const auto expect = [&](const std::string& json, const std::string& message) {
    EXPECT_ERROR(import_nerfstudio(write("transforms.json", json)), message);
  };
  write_image("a.png");
  expect("{", "transforms.json: ");
  expect("{}", "transforms.json: has no frames");
  expect("{\"frames\": [{}]}", "transforms.json: frame 0: has no file_path");
  expect("{\"frames\": [{\"file_path\": \"gone.png\"}]}", "transforms.json: none of its 1 images is there");
  expect("{\"frames\": [{\"file_path\": \"a.png\"}]}", "frame 0: has no fl_x");
  expect("{\"fl_x\": \"long\", \"frames\": [{\"file_path\": \"a.png\"}]}", "frame 0: fl_x is not a number: \"long\"");
  expect("{\"fl_x\": 30, \"frames\": [{\"file_path\": \"a.png\"}]}", "frame 0: transform_matrix is not a 4x4 matrix");
  expect("{\"fl_x\": 30, \"camera_model\": \"FOV\", \"frames\": [{\"file_path\": \"a.png\"}]}",
         "unknown camera_model 'FOV'");
}

TEST_F(Import, KittiOdometryWorldBecomesTheFirstScansFrame) {
  const std::string sequence = "dataset/sequences/07/";
  write_image(sequence + "image_2/000000.png");
  write_image(sequence + "image_2/000001.png");
  for (const char* name : {"velodyne/000000.bin", "velodyne/000001.bin"}) {
    write(sequence + name, bytes_of(5.0f) + bytes_of(1.0f) + bytes_of(2.0f) + bytes_of(0.25f));
  }
  // Camera 2 stands 0.06 m left of camera 0 (t = +0.06), which looks forward 0.3 m behind the LiDAR and 0.1 m below.
  write(sequence + "calib.txt",
        "P0: 700 0 16 0 0 700 12 0 0 0 1 0\nP2: 700 0 16 42 0 700 12 0 0 0 1 0\n"
        "Tr: 0 -1 0 0 0 0 -1 -0.1 1 0 0 0.3\n");
  write(sequence + "times.txt", "0\n0.1\n");
  // Poses of camera 0 in the frame of its first image: it moves 1.5 m forward, along its z axis.
  write("dataset/poses/07.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1.5\n");
  const ImportedProject project = import_kitti_odometry(path(sequence));
  ASSERT_EQ(project.trajectory.size(), 2u);
  expect_near(project.trajectory[1].map_from_sensor.translation, Vector3d(1.5, 0, 0));
  EXPECT_EQ(project.trajectory[1].stamp_s, 0.1);
  // 5 m ahead of the first scan, 1 m left and 2 m up of it.
  expect_near(in_camera(project, "000000.png", Vector3d(5, 1, 2)), Vector3d(-1 + 0.06, -2.1, 5.3));
  expect_near(in_camera(project, "000001.png", Vector3d(5, 1, 2)), Vector3d(-1 + 0.06, -2.1, 3.8));
  EXPECT_EQ(project.model->cameras.at(1).params()[2], 16.0) << "KITTI's pixel centres are whole numbers, as ours";
  EXPECT_EQ(project.stamps_s.at("000001.png"), 0.1);
  EXPECT_EQ(project.scans.size(), 2u);
  EXPECT_EQ(project.rig->trajectory_frame, RigFrame::kLidar);
  const PointCloud scan = read_kitti_scan(project.scans[0].path);
  EXPECT_EQ(scan.positions[0], Eigen::Vector3f(5, 1, 2));
  EXPECT_EQ(scan.intensities[0], 0.25f);
  EXPECT_ERROR(read_kitti_scan(write("broken.bin", "12345")), "broken.bin: 5 bytes are no whole number of points");
  EXPECT_ERROR(import_kitti_odometry(path("dataset")), "dataset/calib.txt: no such file");
}

TEST_F(Import, KittiRawTrajectoryIsOfTheLidarInMercatorMetres) {
  const std::string drive = "2011_09_26/2011_09_26_drive_0009_sync/";
  write("2011_09_26/calib_imu_to_velo.txt", "calib_time: 25-May\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
  write("2011_09_26/calib_velo_to_cam.txt", "calib_time: x\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n");
  write("2011_09_26/calib_cam_to_cam.txt",
        "S_rect_02: 3.2e+01 2.4e+01\nR_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_02: 700 0 16 42 0 700 12 0 0 0 1 0\n");
  // Heads north (yaw 90 degrees) on the equator, where a metre is the same both ways; 1.5 m in 0.1 s, then stands.
  const double metres_per_deg = 6378137.0 * M_PI / 180.0;
  const double north_deg = 1.5 / metres_per_deg;
  for (int i = 0; i < 3; ++i) {
    write(fmt::format("{}oxts/data/{:010d}.txt", drive, i),
          fmt::format("{} 8 100 0 0 {} 0 0\n", i > 0 ? north_deg : 0.0, 0.5 * M_PI));
  }
  write(drive + "oxts/timestamps.txt",
        "2011-09-26 13:02:25.900000000\n2011-09-26 13:02:26.000000000\n2011-09-26 13:02:26.100000000\n");
  write_image(drive + "image_02/data/0000000000.png");
  write(drive + "image_02/timestamps.txt", "2011-09-26 13:02:25.950000000\n");
  write(drive + "velodyne_points/data/0000000000.bin", "");
  write(drive + "velodyne_points/data/0000000001.bin", "");
  write(drive + "velodyne_points/timestamps.txt", "2011-09-26 13:02:25.800000000\n2011-09-26 13:02:26.000000000\n");
  const ImportedProject project = import_kitti_raw(path(drive));
  ASSERT_EQ(project.trajectory.size(), 3u);
  EXPECT_EQ(project.trajectory[1].stamp_s, 1317042146.0) << "2011-09-26 13:02:26 UTC";
  expect_near(project.trajectory[0].map_from_sensor.translation, Vector3d(0, 0, 0));
  expect_near(project.trajectory[1].map_from_sensor.translation, Vector3d(1.5, 0, 0));
  EXPECT_EQ(project.stamps_s.at("0000000000.png"), 1317042145.95);
  ASSERT_EQ(project.scans.size(), 1u) << "the first was taken before the trajectory begins";
  EXPECT_EQ(project.scans[0].name, "0000000001.bin");
  expect_near(project.scan_poses[0].map_from_sensor.translation, Vector3d(1.5, 0, 0));
  expect_near(*project.rig->cameras[0].camera_from_lidar * Vector3d(5, 1, 2), Vector3d(-1 + 0.06, -2.1, 4.7));
  write(drive + "oxts/timestamps.txt", "yesterday\n");
  EXPECT_ERROR(import_kitti_raw(path(drive)), "timestamps.txt:1: not a date and time: 'yesterday'");
}

const char* const kLivoConfig =
    "extrin_calib:\n  extrinsic_T: [0.04, 0.02, -0.03]\n  extrinsic_R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
    "  Rcl: [0, -1, 0, 0, 0, -1, 1, 0, 0]\n  Pcl: [0.1, 0.2, 0.3]\n"
    "time_offset: {img_time_offset: 0.1}\npcd_save: {type: 1}\n"
    "cam_model: Pinhole\ncam_width: 64\ncam_height: 48\nscale: 0.5\ncam_fx: 60\ncam_fy: 60\ncam_cx: 31.5\ncam_cy: "
    "23.5\n";

/// The body stands at (10, 20, 30), turned a quarter to the left.
const char* const kLivoPose = " 10 20 30 0 0 0.70710678118654752 0.70710678118654752\n";

/// What the camera sees of the point that the LiDAR sees 5 m ahead, 1 m left, 2 m up.
const Vector3d kLivoInMap(10 - 1.02, 20 + 5.04, 30 + 1.97);
const Vector3d kLivoInCamera(-0.9, -1.8, 5.3);

TEST_F(Import, GlobalLvbaPosesAreTheImus) {
  for (const char* stamp : {"1661398632.022152", "1661398632.121881"}) {
    write_image(fmt::format("all_image/{}.png", stamp));
    write(fmt::format("all_pcd_body/{}.pcd", stamp), "");
  }
  write_image("all_image/1661398633.000000.png");
  const std::string poses = fmt::format("1661398632.022152{0}1661398632.121881{0}", kLivoPose);
  write("all_image/image_poses.txt", poses);
  write("all_pcd_body/lidar_poses.txt", poses);
  const ImportedProject project = import_global_lvba(path(""), write("config.yaml", kLivoConfig), "");
  EXPECT_EQ(project.images.size(), 3u);
  expect_near(in_camera(project, "1661398632.121881.png", kLivoInMap), kLivoInCamera);
  EXPECT_EQ(project.scans.size(), 2u);
  EXPECT_EQ(project.scan_poses.size(), 2u);
  EXPECT_EQ(project.trajectory.size(), 2u);
  EXPECT_EQ(project.stamps_s.at("1661398632.022152.png"), 1661398632.022152);
  EXPECT_EQ(project.rig->cameras[0].time_offset_s, 0.0) << "the saved stamps are corrected already";
  EXPECT_EQ(project.rig->trajectory_frame, RigFrame::kBody);
  EXPECT_EQ(project.model->cameras.at(1).width(), 32) << "the saved images were scaled by half";
  EXPECT_NEAR(project.model->cameras.at(1).params()[2], 15.5, 1e-12);
  EXPECT_THAT(project.notes, testing::ElementsAre(testing::HasSubstr("1 of 3 images without a pose")));
  EXPECT_ERROR(import_global_lvba(path(""), "", ""), "no rig given");
}

TEST_F(Import, FastLivo2LogFolder) {
  write_image("Log/image/10.500000.png");
  write("Log/image/image_poses.txt", std::string("10.500000") + kLivoPose);
  write("Log/pcd/10.500000.pcd", "");
  write("Log/pcd/lidar_poses.txt", std::string("10.500000") + kLivoPose);
  write("Log/PCD/all_raw_points.pcd", "");
  const ImportedProject project = import_fast_livo2(path(""), write("avia.yaml", kLivoConfig), "");
  expect_near(in_camera(project, "10.500000.png", kLivoInMap), kLivoInCamera);
  EXPECT_EQ(project.map, path("Log/PCD/all_raw_points.pcd"));
  EXPECT_EQ(project.scans.size(), 1u) << "pcd_save.type 1: scans are in the body's frame";
  std::string world = kLivoConfig;
  world.replace(world.find("type: 1"), 7, "type: 0");
  EXPECT_TRUE(import_fast_livo2(path("Log"), write("avia.yaml", world), "").scans.empty());
}

TEST_F(Import, FastLivo2WithColmapOutput) {
  write_image("Log/Colmap/images/00001.png");
  write("Log/Colmap/sparse/0/cameras.txt", "1 PINHOLE 32 24 30 30 16 12\n");
  write("Log/Colmap/sparse/0/images.txt", "1 1 0 0 0 0 0 -2 1 00001.png\n\n");
  write("Log/result/CBD.txt", std::string("10.5") + kLivoPose);
  const ImportedProject project = import_fast_livo2(path("Log"), "", "");
  expect_near(in_camera(project, "00001.png", Vector3d(1, 0, 5)), Vector3d(1, 0, 3));
  EXPECT_EQ(project.trajectory.size(), 1u);
  EXPECT_ERROR(import_fast_livo2(path("Log/result"), "", ""), "neither image/image_poses.txt nor Colmap/sparse/0");
}

const char* const kLioSamHeader =
    "VERSION .7\nFIELDS x y z intensity roll pitch yaw time\nSIZE 4 4 4 4 4 4 4 8\nTYPE F F F F F F F F\n"
    "COUNT 1 1 1 1 1 1 1 1\n";

TEST_F(Import, LioSamAnglesAreRollPitchYaw) {
  write("GlobalMap.pcd", "");
  const double quarter = 0.5 * M_PI;
  write("transformations.pcd",
        fmt::format("{}WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3 0 0 0 {} 100.5\n4 5 6 1 {} {} 0 101.5\n",
                    kLioSamHeader, quarter, quarter, quarter));
  const ImportedProject project = import_lio_sam(path(""));
  ASSERT_EQ(project.trajectory.size(), 2u);
  EXPECT_EQ(project.trajectory[0].stamp_s, 100.5);
  expect_near(project.trajectory[0].map_from_sensor * Vector3d(1, 0, 0), Vector3d(1, 3, 3));
  // The roll turns y to z, then the pitch turns z to x.
  expect_near(project.trajectory[1].map_from_sensor * Vector3d(0, 1, 0), Vector3d(5, 5, 6));
  EXPECT_EQ(project.map, path("GlobalMap.pcd"));

  std::string binary = std::string(kLioSamHeader) + "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n";
  for (const float value : {1.0f, 2.0f, 3.0f, 0.0f, 0.0f, 0.0f, 0.0f}) binary += bytes_of(value);
  write("transformations.pcd", binary + bytes_of(1661398632.25));
  EXPECT_EQ(import_lio_sam(path("")).trajectory[0].stamp_s, 1661398632.25);
  write("transformations.pcd",
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n");
  EXPECT_ERROR(import_lio_sam(path("")), "transformations.pcd: has no field roll");
}

TEST_F(Import, R3LiveHasAMap) {
  EXPECT_ERROR(import_r3live(path("")), "rgb_pt.pcd: no such file");
  write("rgb_pt.pcd", "");
  EXPECT_EQ(import_r3live(path("")).map, path("rgb_pt.pcd"));
}

}  // namespace
}  // namespace cpplus
