#include "cpplus/pipeline/clean_command.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "cpplus/core/error.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/trajectory_io.h"
#include "cpplus/pipeline/scan_folder.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Eigen::Vector3f;

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A wall 6 m ahead of the LiDAR as rows of points, with a panel before it at 3 m where asked for.
PointCloud scan_of_wall(bool with_panel) {
  PointCloud scan;
  for (int row = -40; row <= 40; ++row) {
    for (int column = -40; column <= 40; ++column) {
      const Vector3f direction(1.0f, 0.005f * static_cast<float>(column), 0.005f * static_cast<float>(row));
      const bool on_panel = with_panel && std::abs(row) < 15 && std::abs(column) < 15;
      scan.positions.push_back((on_panel ? 3.0f : 6.0f) * direction);
      scan.intensities.push_back(on_panel ? 200.0f : 100.0f);
    }
  }
  return scan;
}

constexpr size_t kPanelPoints = 29 * 29;

class CleanCommand : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "/clean_command_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(directory_);
    fs::create_directories(directory_ + "/scans");
    options_.scans = directory_ + "/scans";
    options_.poses = directory_ + "/poses.txt";
    options_.out = directory_ + "/static.pcd";
    options_.labels = directory_ + "/labels";
    write_point_cloud(options_.scans + "/a.pcd", scan_of_wall(true));
    write_point_cloud(options_.scans + "/b.ply", scan_of_wall(false));
    write_poses(Vector3d::Zero());
  }

  /// Both scans from the same place: the LiDAR's x axis is the map's y axis.
  void write_poses(const Vector3d& sensor_in_map) {
    const Rigid3 map_from_lidar(so3_exp(Vector3d(0, 0, M_PI / 2)), sensor_in_map);
    write_tum(options_.poses, {{1.0, map_from_lidar}, {2.0, map_from_lidar}});
  }

  std::string directory_;
  CleanCommandOptions options_;
};

TEST_F(CleanCommand, WritesTheStaticPointsAndTheLabels) {
  const CleanSummary summary = run_clean(options_);
  EXPECT_EQ(summary.num_scans, 2u);
  EXPECT_EQ(summary.num_points, 2u * 81u * 81u);
  EXPECT_EQ(summary.num_dynamic, kPanelPoints);
  const PointCloud map = read_point_cloud(options_.out);
  ASSERT_EQ(map.size(), summary.num_points - summary.num_dynamic);
  ASSERT_EQ(map.intensities.size(), map.size());
  for (size_t i = 0; i < map.size(); ++i) {
    EXPECT_NEAR(map.point(i).y(), 6.0, 5e-5);
    EXPECT_EQ(map.intensities[i], 100.0f);
  }
  const std::string labels = bytes_of(options_.labels + "/a.label");
  const PointCloud scan = scan_of_wall(true);
  ASSERT_EQ(labels.size(), scan.size());
  for (size_t i = 0; i < scan.size(); ++i) EXPECT_EQ(labels[i], scan.positions[i].x() < 4.0f ? 1 : 0) << i;
  EXPECT_EQ(bytes_of(options_.labels + "/b.label"), std::string(scan.size(), '\0'));
}

TEST_F(CleanCommand, LabelsCountThePointsOfTheFile) {
  PointCloud scan = scan_of_wall(true);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scan.positions.front().x() = nan;
  scan.positions[40 * 81 + 40].z() = nan;  // in the panel
  scan.positions.back().y() = nan;
  write_point_cloud(options_.scans + "/a.pcd", scan);
  const CleanSummary summary = run_clean(options_);
  EXPECT_EQ(summary.num_dynamic, kPanelPoints - 1);
  const std::string labels = bytes_of(options_.labels + "/a.label");
  ASSERT_EQ(labels.size(), scan.size());
  for (size_t i = 0; i < scan.size(); ++i) {
    EXPECT_EQ(labels[i], scan.positions[i].allFinite() && scan.positions[i].x() < 4.0f ? 1 : 0) << i;
  }
}

TEST_F(CleanCommand, GeoreferencedMapsKeepTheirMillimetres) {
  const Vector3d sensor(691234.5, 5334567.25, 510.0);
  write_poses(sensor);
  EXPECT_EQ(run_clean(options_).num_dynamic, kPanelPoints);
  const ScanFolder folder = read_scan_folder(options_.scans, options_.poses);
  const PointCloud scan = scan_of_wall(true);
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vector3f& p = scan.positions[i];
    EXPECT_LT((folder.scans.points.point(i) - sensor - Vector3d(-p.y(), p.x(), p.z())).norm(), 5e-5);
  }
}

TEST_F(CleanCommand, NothingIsWrittenWhereAScanIsBroken) {
  std::ofstream(options_.scans + "/b.ply") << "ply\n";
  EXPECT_THROW(run_clean(options_), Error);
  EXPECT_FALSE(fs::exists(options_.out));
  EXPECT_FALSE(fs::exists(options_.labels));
}

}  // namespace
}  // namespace cpplus
