#include "cpplus/adjust/adjust_scans.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"
#include "cpplus/simulate/coarse_poses.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180.0;

struct PoseError {
  double rms_deg = 0.0;
  double rms_m = 0.0;
};

/// RMS error after the common rigid motion that makes it least (0.1 degrees counting as much as 2 cm).
PoseError pose_error(const std::vector<Rigid3>& estimate, const std::vector<Rigid3>& truth) {
  const auto n = static_cast<Eigen::Index>(truth.size());
  const double angle_weight = 0.02 / (0.1 * kDegree);
  Vector3d center = Vector3d::Zero();
  for (const Rigid3& pose : truth) center += pose.translation / static_cast<double>(n);
  Eigen::VectorXd errors(6 * n);
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(6 * n, 6);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto scan = static_cast<size_t>(i);
    errors.segment<6>(6 * i) = pose_correction(truth[scan], estimate[scan]);
    motion.block<6, 6>(6 * i, 0).setIdentity();
    for (int axis = 0; axis < 3; ++axis)
      motion.block<3, 1>(6 * i + 3, axis) = Vector3d::Unit(axis).cross(truth[scan].translation - center);
    errors.segment<3>(6 * i) *= angle_weight;
    motion.middleRows<3>(6 * i) *= angle_weight;
  }
  errors -= motion * (motion.transpose() * motion).ldlt().solve(motion.transpose() * errors);
  PoseError error;
  for (Eigen::Index i = 0; i < n; ++i) {
    error.rms_deg += errors.segment<3>(6 * i).squaredNorm() / static_cast<double>(n);
    error.rms_m += errors.segment<3>(6 * i + 3).squaredNorm() / static_cast<double>(n);
  }
  return {std::sqrt(error.rms_deg) / angle_weight / kDegree, std::sqrt(error.rms_m)};
}

struct Scans {
  std::vector<PointCloud> in_lidar;
  std::vector<Rigid3> truth;
  std::vector<double> stamps_s;

  ScanSet at(const std::vector<Rigid3>& map_from_lidar) const {
    ScanSet scans;
    for (size_t i = 0; i < in_lidar.size(); ++i) {
      for (size_t k = 0; k < in_lidar[i].size(); ++k)
        scans.points.positions.push_back((map_from_lidar[i] * in_lidar[i].point(k)).cast<float>());
      scans.first_point.push_back(scans.points.size());
      scans.sensors_in_map.push_back(map_from_lidar[i].translation);
    }
    return scans;
  }

  /// The truth with a smooth error of this RMS.
  std::vector<Rigid3> drifted(double rms_m, double rms_deg) const {
    const SmoothNoise noise(11, 8.0, 40.0);
    Vector3d squares = Vector3d::Zero();
    for (const double stamp : stamps_s) {
      squares[0] += noise.at(stamp).head<3>().squaredNorm() / static_cast<double>(stamps_s.size());
      squares[1] += noise.at(stamp).tail<3>().squaredNorm() / static_cast<double>(stamps_s.size());
    }
    std::vector<Rigid3> poses;
    for (size_t i = 0; i < truth.size(); ++i) {
      const Vector6d error = noise.at(stamps_s[i]);
      const Eigen::Quaterniond turn(so3_exp(rms_deg * kDegree / std::sqrt(squares[0]) * error.head<3>()));
      poses.emplace_back(turn * truth[i].rotation,
                         truth[i].translation + rms_m / std::sqrt(squares[1]) * error.tail<3>());
    }
    return poses;
  }
};

Scans simulate_scans(const std::string& scene) {
  SimulateOptions options;
  options.scene = scene;
  options.seed = 4;
  options.width = 32;
  options.height = 24;
  options.images = 1;
  options.blurred = 0;
  options.scans = 20;
  options.lidar.azimuth_steps = 720;
  Scans scans;
  for (SimulatedScan& scan : simulate_world(options).scans) {
    scans.in_lidar.push_back(std::move(scan.scan.points));
    scans.truth.push_back(scan.true_map_from_lidar);
    scans.stamps_s.push_back(scan.stamp_s);
  }
  return scans;
}

/// The hall has walking people in it.
const Scans& hall() {
  static const Scans scans = simulate_scans("hall");
  return scans;
}

TEST(AdjustScans, HalvesTheErrorOfDriftedPoses) {
  const std::vector<Rigid3> input = hall().drifted(0.02, 0.1);
  const AdjustResult result = adjust_scans(hall().at(input), input, {});
  EXPECT_EQ(result.status, AdjustStatus::kAdjusted);
  const PoseError before = pose_error(input, hall().truth);
  const PoseError after = pose_error(result.map_from_lidar, hall().truth);
  EXPECT_LT(after.rms_m, 0.5 * before.rms_m);
  EXPECT_LT(after.rms_deg, 0.5 * before.rms_deg);
  EXPECT_LT(result.thickness.after_m, result.thickness.before_m);
}

TEST(AdjustScans, GoodPosesGetNoWorse) {
  const std::vector<Rigid3> input = hall().drifted(0.005, 0.03);
  const AdjustResult result = adjust_scans(hall().at(input), input, {});
  const PoseError before = pose_error(input, hall().truth);
  const PoseError after = pose_error(result.map_from_lidar, hall().truth);
  EXPECT_LE(after.rms_m, before.rms_m);
  EXPECT_LE(after.rms_deg, before.rms_deg);
}

TEST(AdjustScans, TruePosesStayAsTheyAre) {
  const AdjustResult result = adjust_scans(hall().at(hall().truth), hall().truth, {});
  EXPECT_EQ(result.status, AdjustStatus::kKeptNotThinner);
  for (size_t i = 0; i < hall().truth.size(); ++i) {
    EXPECT_EQ(result.map_from_lidar[i].translation, hall().truth[i].translation);
    EXPECT_EQ(result.map_from_lidar[i].rotation.coeffs(), hall().truth[i].rotation.coeffs());
    EXPECT_LT(result.scans[i].correction.tail<3>().norm(), 0.005) << "what was found, though not taken";
  }
}

TEST(AdjustScans, IsTheSameForAnyNumberOfThreads) {
  const int before = num_threads();
  const std::vector<Rigid3> input = hall().drifted(0.02, 0.1);
  AdjustOptions options;
  options.max_iterations = 2;
  std::vector<AdjustResult> results;
  for (const int threads : {1, 2}) {
    set_num_threads(threads);
    results.push_back(adjust_scans(hall().at(input), input, options));
  }
  set_num_threads(before);
  EXPECT_EQ(results[0].thickness.after_m, results[1].thickness.after_m);
  for (size_t i = 0; i < input.size(); ++i) {
    EXPECT_EQ(results[0].scans[i].correction, results[1].scans[i].correction);
    EXPECT_EQ(results[0].scans[i].sigma, results[1].scans[i].sigma);
  }
}

TEST(AdjustScans, FewerThanThreeScansAreKept) {
  Scans two = hall();
  two.in_lidar.resize(2);
  two.truth.resize(2);
  const AdjustResult result = adjust_scans(two.at(two.truth), two.truth, {});
  EXPECT_EQ(result.status, AdjustStatus::kKeptTooFewScans);
  EXPECT_EQ(result.map_from_lidar[1].translation, two.truth[1].translation);
}

/// A corridor without ends along x: floor, ceiling and two walls, seen from places along it.
Scans endless_corridor() {
  Scans scans;
  Random random(2);
  for (int i = 0; i < 8; ++i) {
    const Vector3d sensor(0.5 * i, 0.1 * std::sin(i), 1.2);
    PointCloud points;
    for (int k = 0; k < 8000; ++k) {
      const double x = random.uniform(-8.0, 12.0);
      const double across = random.uniform(-1.0, 1.0);
      const double side = k % 2 == 0 ? 1.0 : -1.0;
      const Vector3d wall(x, side + 0.005 * random.normal(), 1.25 + 1.25 * across);
      const Vector3d level(x, across, 1.25 + 1.25 * side + 0.005 * random.normal());
      points.positions.push_back(((k % 4 < 2 ? wall : level) - sensor).cast<float>());
    }
    scans.in_lidar.push_back(points);
    scans.truth.emplace_back(Eigen::Quaterniond::Identity(), sensor);
    scans.stamps_s.push_back(i);
  }
  return scans;
}

TEST(AdjustScans, NamesTheAxisOfAnEndlessCorridorAndLeavesItAlone) {
  const Scans scans = endless_corridor();
  const std::vector<Rigid3> input = scans.drifted(0.02, 0.05);
  const AdjustResult result = adjust_scans(scans.at(input), input, {});
  EXPECT_EQ(result.status, AdjustStatus::kAdjusted);
  Vector3d mean = Vector3d::Zero();
  for (const ScanAdjustment& scan : result.scans) mean += scan.correction.tail<3>() / 8.0;
  for (size_t i = 0; i < 8; ++i) {
    const ScanAdjustment& scan = result.scans[i];
    ASSERT_EQ(scan.weak_directions.size(), 1u) << i;
    EXPECT_GT(std::abs(scan.weak_directions[0].direction.x()), 0.99) << i;
    EXPECT_LT(std::abs(scan.correction[3] - mean.x()), 0.006) << i;  // of 20 mm of drift: it is not guessed
    EXPECT_LT(scan.sigma[4], 0.003) << i;
  }
}

}  // namespace
}  // namespace cpplus
