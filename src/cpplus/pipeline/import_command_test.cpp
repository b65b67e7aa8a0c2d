#include "cpplus/pipeline/import_command.h"

#include <fmt/format.h>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/options_yaml.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/test_bag.h"
#include "cpplus/io/test_files.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/clean_command.h"
#include "cpplus/pipeline/colorize_command.h"
#include "cpplus/pipeline/poses_command.h"
#include "cpplus/pipeline/refine_command.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

class ImportCommand : public FileTest {
 protected:
  ImportCommandOptions options(const std::string& format, const std::string& source) const {
    ImportCommandOptions options;
    options.format = format;
    options.source = path(source);
    options.out = path("project");
    return options;
  }

  void write_image(const std::string& name) const {
    write(name, "");
    write_png(path(name), ColorImage(32, 24));
  }

  void write_cloud(const std::string& name) const {
    PointCloud cloud;
    cloud.positions = {{1, 2, 3}, {4, 5, 6}};
    write_point_cloud(path(name), cloud);
  }

  /// A sequence of KITTI with two images, scans and poses.
  void write_kitti() const {
    for (const char* name : {"000000", "000001"}) {
      write_image(fmt::format("07/image_2/{}.png", name));
      write(fmt::format("07/velodyne/{}.bin", name),
            bytes_of(5.0f) + bytes_of(1.0f) + bytes_of(2.0f) + bytes_of(0.25f));
    }
    write("07/calib.txt", "P2: 30 0 16 0 0 30 12 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
    write("07/times.txt", "0\n0.1\n");
    write("07/poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1.5\n");
  }

  /// The sections that commands would take of project.yaml.
  struct Sections {
    CleanCommandOptions clean;
    PosesCommandOptions poses;
    RefineCommandOptions refine;
    ColorizeCommandOptions colorize;
  };
  Sections sections() const {
    Sections sections;
    std::vector<OptionField> fields = list_options(sections.poses, "poses");
    for (const OptionField& field : list_options(sections.clean, "clean")) fields.push_back(field);
    for (const OptionField& field : list_options(sections.refine, "refine")) fields.push_back(field);
    for (const OptionField& field : list_options(sections.colorize, "colorize")) fields.push_back(field);
    read_options_yaml(path("project/project.yaml"), fields);
    return sections;
  }
};

TEST_F(ImportCommand, KittiProjectIsWhole) {
  write_kitti();
  write_cloud("lidar.pcd");
  ImportCommandOptions import = options("kitti", "07");
  import.map = path("lidar.pcd");
  const ImportSummary summary = import_command(import);
  EXPECT_TRUE(summary.has_map);
  EXPECT_EQ(summary.num_images, 2u);
  EXPECT_EQ(summary.num_posed, 2u);
  EXPECT_EQ(summary.num_scans, 2u);
  EXPECT_TRUE(fs::is_symlink(path("project/images/000001.png")));
  EXPECT_EQ(read_image_size(path("project/images/000001.png")).width, 32);
  EXPECT_EQ(read_point_cloud(path("project/scans/000001.pcd")).point(0), Eigen::Vector3d(5, 1, 2));
  const Trajectory scan_poses = read_tum(path("project/scans/poses.txt"));
  EXPECT_TRUE(scan_poses[1].map_from_sensor.translation.isApprox(Eigen::Vector3d(1.5, 0, 0), 1e-9));
  EXPECT_EQ(read_stamps(path("project/stamps.txt")).at("000001.png"), 0.1);
  const SparseModel model = read_sparse_model(path("project/coarse"));
  ASSERT_EQ(model.images.size(), 2u);
  EXPECT_TRUE(camera_center(model.images[1].camera_from_map).isApprox(Eigen::Vector3d(1.5, 0, 0), 1e-9));
  EXPECT_EQ(read_point_cloud(path("project/map.pcd")).size(), 2u);
  const Sections read = sections();
  EXPECT_EQ(read.refine.map, path("project/map.pcd"));
  EXPECT_EQ(read.refine.poses, path("project/coarse"));
  EXPECT_EQ(read.refine.stamps, path("project/stamps.txt"));
  EXPECT_EQ(read.colorize.poses, path("project/refined/sparse"));
  read.refine.validate();
  read.colorize.validate();
}

TEST_F(ImportCommand, ScansWithoutAMapMakeOne) {
  write_kitti();
  import_command(options("kitti", "07"));
  const Sections read = sections();
  EXPECT_EQ(read.clean.scans, path("project/scans"));
  EXPECT_EQ(read.clean.poses, path("project/scans/poses.txt"));
  EXPECT_EQ(read.clean.out, path("project/static_map.pcd"));
  EXPECT_EQ(read.refine.map, read.clean.out);
  EXPECT_EQ(read.colorize.map, read.clean.out);
  read.clean.validate();
  read.refine.validate();
}

TEST_F(ImportCommand, ARigAndATrajectoryAreMadeIntoPosesLater) {
  write_cloud("r3live/rgb_pt.pcd");
  write_image("photos/0.5.png");
  write("poses.txt", "0 0 0 0 0 0 0 1\n0.4 0.6 0 0 0 0 0 1\n0.8 1.2 0 0 0 0 0 1\n");
  write("config.yaml",
        "r3live_vio: {image_width: 32, image_height: 24, camera_intrinsic: [30, 0, 15.5, 0, 30, 11.5, 0, 0, 1],\n"
        "  camera_dist_coeffs: [0, 0, 0, 0, 0], camera_ext_R: [0, 0, 1, -1, 0, 0, 0, -1, 0], camera_ext_t: [0.2, 0, "
        "0]}\n");
  ImportCommandOptions import = options("r3live", "r3live");
  import.images = path("photos");
  import.trajectory = path("poses.txt");
  import.rig = path("config.yaml");
  import.copy = true;
  import_command(import);
  EXPECT_FALSE(fs::is_symlink(path("project/map.pcd")));
  const Sections read = sections();
  EXPECT_EQ(poses_command(read.poses).num_posed, 1u);
  const SparseModel model = read_sparse_model(read.refine.poses);
  EXPECT_TRUE(camera_center(model.images[0].camera_from_map).isApprox(Eigen::Vector3d(0.95, 0, 0), 1e-9));
  EXPECT_EQ(read.refine.stamps, path("project/coarse/stamps.txt"));
  EXPECT_TRUE(fs::exists(read.refine.stamps));
}

TEST_F(ImportCommand, ABagIsUnpackedIntoTheProject) {
  testing_bag::BagBuilder bag;
  for (int i = 0; i < 4; ++i) bag.add("/odom", "nav_msgs/Odometry", testing_bag::odometry(12.0 + 0.1 * i, i));
  bag.add("/camera", "sensor_msgs/Image", testing_bag::image(12.125, "mono8", std::string(2, 'a')));
  write("recorded.bag", bag.bytes());
  write("rig.yaml",
        "cameras: {camera: {model: PINHOLE, width: 2, height: 1, params: [3, 3, 1, 0.5],\n"
        "  camera_from_lidar: {quaternion_wxyz: [0.5, 0.5, -0.5, 0.5], translation: [0, 0, 0]}}}\n");
  ImportCommandOptions import = options("rosbag", "recorded.bag");
  import.rig = path("rig.yaml");
  EXPECT_EQ(import_command(import).num_images, 1u);
  EXPECT_FALSE(fs::is_symlink(path("project/images/12.125000.png")));
  EXPECT_EQ(poses_command(sections().poses).num_posed, 1u);
  import.source = path("rig.yaml");
  import.out = path("second");
  EXPECT_ERROR(import_command(import), "rig.yaml: not a ROS 1 bag");
  EXPECT_FALSE(fs::exists(path("second")));
}

TEST_F(ImportCommand, NothingIsLeftOfAFailure) {
  write_kitti();
  write("07/velodyne/000001.bin", "12345");
  EXPECT_ERROR(import_command(options("kitti", "07")), "000001.bin: 5 bytes are no whole number of points");
  EXPECT_EQ(num_files(), 1u) << "only the source";
}

TEST_F(ImportCommand, ReplacesAnEarlierImportAndNothingElse) {
  write_kitti();
  write_cloud("lidar.pcd");
  ImportCommandOptions import = options("kitti", "07");
  import.map = path("lidar.pcd");
  import_command(import);
  write("project/refined/report.json", "of a later step");
  EXPECT_ERROR(import_command(import), "is there already; an import makes a new folder, or with option replace");
  import.map.clear();
  import.replace = true;
  fs::remove(path("07/poses.txt"));
  write("07/poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2.5\n");
  import_command(import);
  EXPECT_FALSE(fs::exists(path("project/map.pcd"))) << "of the earlier import alone";
  EXPECT_EQ(read("project/refined/report.json"), "of a later step");
  EXPECT_NEAR(read_tum(path("project/scans/poses.txt"))[1].map_from_sensor.translation.x(), 2.5, 1e-9);
  write("project/project.yaml", "# by hand");
  EXPECT_ERROR(import_command(import), "project: is there already; an import makes a new folder");
}

TEST_F(ImportCommand, BadInput) {
  write_kitti();
  EXPECT_THROW(import_command(options("rtabmap", "07")), UsageError);
  EXPECT_ERROR(import_command(options("kitti", "08")), "08: no such file or folder");
  EXPECT_THROW(import_command(ImportCommandOptions{}), UsageError);
  write("project/notes.txt", "mine");
  EXPECT_ERROR(import_command(options("kitti", "07")), "project: is there already; an import makes a new folder");
  EXPECT_EQ(read("project/notes.txt"), "mine");
  ImportCommandOptions without_map = options("kitti", "07");
  without_map.out = path("empty");
  without_map.map = path("none.pcd");
  fs::create_directory(path("empty"));
  EXPECT_ERROR(import_command(without_map), "none.pcd: no such file");
  EXPECT_TRUE(fs::is_empty(path("empty")));
  without_map.map = "";
  import_command(without_map);
  EXPECT_TRUE(fs::exists(path("empty/project.yaml"))) << "an empty folder may be there";
}

}  // namespace
}  // namespace cpplus
