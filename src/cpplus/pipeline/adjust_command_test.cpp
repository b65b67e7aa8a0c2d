#include "cpplus/pipeline/adjust_command.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/core/random.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/trajectory_io.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

/// Five scans of the inside of a box of 6 m x 5 m x 3 m, from one place, with wrong poses.
class AdjustCommand : public testing::Test {
 protected:
  static constexpr int kScans = 5;

  void SetUp() override {
    const std::string directory =
        testing::TempDir() + "/adjust_command_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(directory);
    fs::create_directories(directory + "/scans");
    options_.scans = directory + "/scans";
    options_.poses = directory + "/poses.txt";
    options_.out = directory + "/adjusted.txt";
    options_.map = directory + "/map.ply";
    Random random(1);
    Trajectory poses;
    for (int scan = 0; scan < kScans; ++scan) {
      write_point_cloud(scan_path(scan), box_scan(&random));
      const Vector3d error(0.03 * random.normal(), 0.03 * random.normal(), 0.03 * random.normal());
      poses.push_back({1.0 + scan, Rigid3(Eigen::Quaterniond::Identity(), kOffset + error)});
    }
    write_tum(options_.poses, poses);
  }

  std::string scan_path(int scan) const { return options_.scans + "/" + std::to_string(scan) + ".pcd"; }

  static PointCloud box_scan(Random* random) {
    const Vector3d half(3.0, 2.5, 1.5);
    PointCloud scan;
    for (int i = 0; i < 6000; ++i) {
      Vector3d point = Vector3d::NullaryExpr([&] { return random->uniform(-1.0, 1.0); }).cwiseProduct(half);
      const int axis = i % 3;
      point[axis] = (i % 2 == 0 ? 1.0 : -1.0) * half[axis] + 0.01 * random->normal();
      scan.positions.push_back(point.cast<float>());
    }
    return scan;
  }

  static double spread(const std::string& path) {
    double sum = 0.0;
    const Trajectory poses = read_tum(path);
    Vector3d mean = Vector3d::Zero();
    for (const StampedPose& pose : poses) mean += pose.map_from_sensor.translation / kScans;
    for (const StampedPose& pose : poses) sum += (pose.map_from_sensor.translation - mean).squaredNorm() / kScans;
    return std::sqrt(sum);
  }

  static inline const Vector3d kOffset = Vector3d(0.3, 0.2, 0.1);
  AdjustCommandOptions options_;
};

TEST_F(AdjustCommand, WritesPosesReportAndMap) {
  EXPECT_EQ(run_adjust(options_).status, AdjustStatus::kAdjusted);
  EXPECT_GT(spread(options_.poses), 0.03);
  EXPECT_LT(spread(options_.out), 0.003);
  EXPECT_EQ(read_tum(options_.out).back().stamp_s, 5.0);
  EXPECT_EQ(read_point_cloud(options_.map).size(), 30000u);

  const nlohmann::json report = nlohmann::json::parse(std::ifstream(adjust_report_path(options_.out)));
  EXPECT_EQ(report["status"], "adjusted");
  EXPECT_GT(report["held_out"]["thickness_before_m"], 0.015);
  const double after_m = report["held_out"]["thickness_after_m"];
  EXPECT_LT(after_m, 0.7 * report["held_out"]["thickness_before_m"].get<double>());
  EXPECT_EQ(report["scans"].size(), 5u);
  EXPECT_EQ(report["scans"][4]["name"], "4.pcd");
  EXPECT_EQ(report["scans"][4]["correction"].size(), 6u);
}

TEST_F(AdjustCommand, PointsThatAreNotFiniteDoNotMatter) {
  PointCloud scan = read_point_cloud(scan_path(2));
  scan.positions.front().x() = std::numeric_limits<float>::quiet_NaN();
  scan.positions.back().z() = std::numeric_limits<float>::infinity();
  write_point_cloud(scan_path(2), scan);
  EXPECT_EQ(run_adjust(options_).status, AdjustStatus::kAdjusted);
  EXPECT_LT(spread(options_.out), 0.003);
  EXPECT_EQ(read_point_cloud(options_.map).size(), 29998u);
}

TEST_F(AdjustCommand, AdjustedPosesAreKeptTheSecondTime) {
  run_adjust(options_);
  options_.poses = options_.out;
  options_.out += ".again.txt";
  EXPECT_EQ(run_adjust(options_).status, AdjustStatus::kKeptNotThinner);
  EXPECT_EQ(spread(options_.out), spread(options_.poses));
}

TEST_F(AdjustCommand, NothingIsWrittenWhereAScanIsBroken) {
  std::ofstream(scan_path(1)) << "no scan";
  EXPECT_THROW(run_adjust(options_), Error);
  EXPECT_FALSE(fs::exists(options_.out));
  EXPECT_FALSE(fs::exists(options_.map));
}

TEST_F(AdjustCommand, TheReportMustNotTakeTheTrajectorysPlace) {
  options_.out = "poses.json";
  EXPECT_THROW(run_adjust(options_), UsageError);
}

}  // namespace
}  // namespace cpplus
