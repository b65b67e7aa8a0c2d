#include "cpplus/dynamics/find_dynamics.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/leaf_vote.h"
#include "cpplus/dynamics/see_through.h"
#include "cpplus/dynamics/test_scans.h"
#include "cpplus/simulate/lidar.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/scene.h"

namespace cpplus {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

const AlignedBox3d ground(Vector3d(-60, -60, -1), Vector3d(60, 60, 0));
const AlignedBox3d wall(Vector3d(6, -10, 0), Vector3d(6.2, 10, 4));

AlignedBox3d person_at(double x, double y) {
  return {Vector3d(x - 0.2, y - 0.3, 0.0), Vector3d(x + 0.2, y + 0.3, 1.75)};
}

/// Share of the points of one box that carry a label.
double share_of(const std::vector<uint8_t>& labels, const std::vector<size_t>& box_of_point, size_t box,
                uint8_t label) {
  size_t all = 0;
  size_t with_label = 0;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (box_of_point[i] != box) continue;
    ++all;
    if (labels[i] == label) ++with_label;
  }
  EXPECT_GT(all, 0u) << "no point of box " << box;
  return static_cast<double>(with_label) / static_cast<double>(all);
}

std::vector<uint8_t> labels_of(const ScanSet& scans, const DynamicsOptions& options = {}) {
  return find_dynamics(VoxelMap(scans.points, {}), scans, options).labels;
}

void add_scan(ScanSet* scans, const Vector3d& sensor, const std::vector<Vector3d>& points) {
  for (const Vector3d& point : points) scans->points.positions.push_back(point.cast<float>());
  scans->first_point.push_back(scans->points.size());
  scans->sensors_in_map.push_back(sensor);
}

/// Through the leaf of a point, and near it.
std::pair<uint32_t, uint32_t> times_passed(const ScanSet& scans, const Vector3d& point) {
  const VoxelMap map(scans.points, {});
  const SeeThrough seen = count_see_through(map, scans, measure_leaf_surfaces(map, scans), {});
  const uint32_t leaf = *map.find_leaf(point);
  return {seen.num_through.at(leaf), seen.num_near.at(leaf)};
}

uint32_t times_seen_through(const ScanSet& scans, const Vector3d& point) { return times_passed(scans, point).first; }

TEST(SeeThrough, TheRayOfAnotherScanCounts) {
  ScanSet scans;
  const Vector3d near(2.03, 0.03, 0.03);
  add_scan(&scans, {0.0, 0.03, 0.03}, {near});
  add_scan(&scans, {0.0, 0.03, 0.03}, {{4.03, 0.03, 0.03}});
  EXPECT_EQ(times_seen_through(scans, near), 1u);
  EXPECT_EQ(times_seen_through(scans, {4.03, 0.03, 0.03}), 0u);
}

TEST(SeeThrough, RaysBesideWhatOneScanAloneHitsAreNear) {
  const Vector3d sensor(0.0, 0.03, 0.03);
  const Vector3d far_point(20.03, 0.03, 0.03);
  const auto passed_with_ray_to = [&](const Vector3d& end, int num_hits) {
    ScanSet scans;
    for (int i = 0; i < num_hits; ++i) add_scan(&scans, sensor, {far_point});
    add_scan(&scans, sensor, {end});
    return times_passed(scans, far_point);
  };
  EXPECT_EQ(passed_with_ray_to({40.03, 0.18, 0.03}, 1), std::make_pair(0u, 1u)) << "7.5 cm beside it";
  EXPECT_EQ(passed_with_ray_to({40.03, 0.31, 0.03}, 1), std::make_pair(0u, 0u)) << "14 cm beside it";
  EXPECT_EQ(passed_with_ray_to({40.03, 0.18, 0.03}, 2), std::make_pair(0u, 0u)) << "two scans hit it";
  EXPECT_EQ(passed_with_ray_to({40.03, 0.03, 0.03}, 1), std::make_pair(1u, 1u)) << "through it";
  EXPECT_EQ(passed_with_ray_to({20.5, 0.1, 0.03}, 1), std::make_pair(0u, 0u)) << "it ends shortly behind";
  EXPECT_EQ(passed_with_ray_to({22.2, 0.03, -0.07}, 1), std::make_pair(0u, 0u)) << "it may end on ground behind";
  EXPECT_EQ(passed_with_ray_to({24.2, 0.03, -0.08}, 1), std::make_pair(0u, 1u)) << "too far behind for that";
}

TEST(SeeThrough, CountingStopsWhereItIsSufficient) {
  ScanSet scans;
  const Vector3d near(2.03, 0.03, 0.03);
  add_scan(&scans, {0.0, 0.03, 0.03}, {near});
  for (int i = 0; i < 9; ++i) add_scan(&scans, {0.0, 0.03, 0.03}, {{4.03, 0.03, 0.03}});
  EXPECT_EQ(times_seen_through(scans, near), sufficient_scans(1, scans.num_scans(), {}));
}

TEST(SeeThrough, AScanDoesNotSeeThroughWhatItHits) {
  // Two beams of one scan through the same leaf, one of which ends there: self-intersection.
  ScanSet scans;
  const Vector3d near(2.03, 0.03, 0.03);
  add_scan(&scans, {0.0, 0.03, 0.03}, {near, {4.03, 0.03, 0.03}});
  EXPECT_EQ(times_seen_through(scans, near), 0u);
}

TEST(SeeThrough, AScanDoesNotSeeThroughWhatIsBesideItsHit) {
  ScanSet scans;
  const Vector3d near(2.03, 0.03, 0.03);
  add_scan(&scans, {0.0, 0.03, 0.03}, {near});
  // The second scan hits the leaf above (a foreground edge) and passes below it.
  add_scan(&scans, {0.0, 0.03, 0.03}, {{2.03, 0.03, 0.09}, {4.03, 0.03, 0.03}});
  EXPECT_EQ(times_seen_through(scans, near), 0u);
}

TEST(SeeThrough, RaysThatEndShortlyBehindDoNotCount) {
  ScanSet scans;
  const Vector3d near(2.03, 0.03, 0.03);
  add_scan(&scans, {0.0, 0.03, 0.03}, {near});
  add_scan(&scans, {0.0, 0.03, 0.03}, {{2.25, 0.03, 0.03}});  // 22 cm, the gap is 25
  EXPECT_EQ(times_seen_through(scans, near), 0u);
}

TEST(FindDynamics, APersonInFrontOfAWallInOneOfTwoScansGoes) {
  ScanSet scans;
  std::vector<size_t> box_of_point;
  BoxScanner scanner;
  scanner.step_deg = 0.5;
  const Vector3d sensor(0, 0, 1.2);
  scanner.scan({ground, wall, person_at(3.5, 0.4)}, sensor, &scans, &box_of_point);
  scanner.scan({ground, wall}, sensor, &scans, &box_of_point);
  const std::vector<uint8_t> labels = labels_of(scans);
  EXPECT_GE(share_of(labels, box_of_point, 2, 1), 0.93);
  EXPECT_GE(share_of(labels, box_of_point, 1, 0), 0.999);
  EXPECT_GE(share_of(labels, box_of_point, 0, 0), 0.995);
}

TEST(FindDynamics, APersonWhomFewBeamsMeetGoes) {
  // A beam each 0.7 degrees: 41 cm apart at the person, four to six points on him, who walks 60 cm between scans.
  ScanSet scans;
  std::vector<size_t> box_of_point;
  const AlignedBox3d far_wall(Vector3d(45, -12, 0), Vector3d(45.2, 12, 8));
  BoxScanner scanner;
  scanner.step_deg = 0.7;
  scanner.lowest_deg = -10.5;
  scanner.highest_deg = 10.5;
  for (int i = 0; i < 24; ++i) {
    const Vector3d sensor(0.13 * i, -0.21 * i, 1.2);
    scanner.scan({ground, far_wall, person_at(34.0, -6.0 + 0.6 * i)}, sensor, &scans, &box_of_point);
  }
  const std::vector<uint8_t> labels = labels_of(scans);
  EXPECT_GE(share_of(labels, box_of_point, 2, 1), 0.9);
  EXPECT_GE(share_of(labels, box_of_point, 1, 0), 0.99);
  EXPECT_GE(share_of(labels, box_of_point, 0, 0), 0.99);
}

TEST(FindDynamics, TheSameScanTwiceHasNothingDynamic) {
  ScanSet scans;
  std::vector<size_t> box_of_point;
  BoxScanner scanner;
  scanner.noise_m = 0.0;
  for (int i = 0; i < 2; ++i) {
    scanner.scan({ground, wall, person_at(3.5, 0.4)}, {0, 0, 1.2}, &scans, &box_of_point);
  }
  EXPECT_THAT(labels_of(scans), testing::Each(0));
}

TEST(FindDynamics, GrazedGroundIsNotEaten) {
  ScanSet scans;
  std::vector<size_t> box_of_point;
  BoxScanner scanner;
  scanner.lowest_deg = -20.0;
  scanner.highest_deg = -1.5;  // 46 m away
  scanner.step_deg = 0.7;
  scanner.noise_m = 0.02;
  for (int i = 0; i < 12; ++i) scanner.scan({ground}, {1.1 * i, 0.3 * i, 1.2}, &scans, &box_of_point);
  EXPECT_GE(share_of(labels_of(scans), box_of_point, 0, 0), 0.99);
}

TEST(FindDynamics, AThinPoleStays) {
  ScanSet scans;
  std::vector<size_t> box_of_point;
  const AlignedBox3d pole(Vector3d(4.0, 0.9, 0.0), Vector3d(4.06, 0.96, 2.5));
  BoxScanner scanner;
  scanner.noise_m = 0.02;
  for (int i = 0; i < 12; ++i) scanner.scan({ground, wall, pole}, {0.17 * i, -0.21 * i, 1.2}, &scans, &box_of_point);
  const std::vector<uint8_t> labels = labels_of(scans);
  EXPECT_GE(share_of(labels, box_of_point, 2, 0), 0.9);
  EXPECT_GE(share_of(labels, box_of_point, 1, 0), 0.99);
}

TEST(FindDynamics, PointsThatAreNotFiniteAreStatic) {
  ScanSet scans;
  std::vector<size_t> box_of_point;
  const BoxScanner scanner;
  scanner.scan({ground, wall, person_at(3.5, 0.4)}, {0, 0, 1.2}, &scans, &box_of_point);
  scanner.scan({ground, wall}, {0, 0, 1.2}, &scans, &box_of_point);
  const std::vector<uint8_t> labels = labels_of(scans);
  const auto first = std::find(labels.begin(), labels.end(), 1);
  ASSERT_NE(first, labels.end());
  scans.points.positions[static_cast<size_t>(first - labels.begin())].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(labels_of(scans)[static_cast<size_t>(first - labels.begin())], 0);
}

TEST(FindDynamics, TakesOptionsInTheirRangeOnly) {
  const auto rejects = [](const auto& spoil) {
    DynamicsOptions options;
    spoil(&options);
    EXPECT_THROW(options.validate(), UsageError);
  };
  rejects([](DynamicsOptions* o) { o->max_range_m = 0.0; });
  rejects([](DynamicsOptions* o) { o->ray_radius_m = -1.0; });
  rejects([](DynamicsOptions* o) { o->min_gap_m = -0.1; });
  rejects([](DynamicsOptions* o) { o->surface_gap_m = std::nan(""); });
  rejects([](DynamicsOptions* o) { o->range_gap = 1.0; });
  rejects([](DynamicsOptions* o) { o->min_grazing_deg = 90.0; });
  rejects([](DynamicsOptions* o) { o->plane_distance_m = -0.1; });
  rejects([](DynamicsOptions* o) { o->min_share = -0.1; });
  rejects([](DynamicsOptions* o) { o->near_radius_m = 0.0; });
  rejects([](DynamicsOptions* o) { o->near_grazing_deg = 90.0; });
  rejects([](DynamicsOptions* o) { o->near_share = 0.0; });
  rejects([](DynamicsOptions* o) { o->sure_share = std::nan(""); });
  rejects([](DynamicsOptions* o) { o->keep_share = 1.1; });
  rejects([](DynamicsOptions* o) { o->fill_share = 0.0; });
}

/// A simulated scene as a LiDAR that moves sees it, with range noise, mixed pixels and the pose errors of an odometry.
ScanSet simulated_scans(const std::string& scene_name, uint64_t seed, int num_scans, std::vector<uint8_t>* truth) {
  const Scene scene = build_scene(scene_name, seed);
  const Tracer tracer(scene);
  const Path path(scene.way);
  LidarOptions lidar;
  lidar.azimuth_steps = 900;
  Random random(seed);
  ScanSet scans;
  for (int i = 0; i < num_scans; ++i) {
    const double stamp = path.duration_s() * (i + 0.5) / num_scans;
    const Rigid3 map_from_lidar = path.map_from_lidar(stamp);
    const LidarScan scan = fire_scan(tracer, map_from_lidar, stamp, i, seed, lidar);
    const Vector3d turn = 0.03 * M_PI / 180.0 * Vector3d(random.normal(), random.normal(), random.normal());
    const Vector3d shift = 0.005 * Vector3d(random.normal(), random.normal(), random.normal());
    const Rigid3 stated = map_from_lidar * Rigid3(so3_exp(turn), shift);
    for (size_t k = 0; k < scan.points.size(); ++k) {
      scans.points.positions.push_back((stated * scan.points.point(k)).cast<float>());
    }
    truth->insert(truth->end(), scan.labels.begin(), scan.labels.end());
    scans.first_point.push_back(scans.points.size());
    scans.sensors_in_map.push_back(stated.translation);
  }
  return scans;
}

struct Accuracy {
  double static_kept = 0.0;
  double dynamic_removed = 0.0;
};

Accuracy accuracy_of(const std::vector<uint8_t>& labels, const std::vector<uint8_t>& truth) {
  std::array<double, 2> all{};
  std::array<double, 2> right{};
  for (size_t i = 0; i < labels.size(); ++i) {
    all[truth[i]] += 1.0;
    right[truth[i]] += labels[i] == truth[i] ? 1.0 : 0.0;
  }
  return {right[0] / all[0], right[1] / all[1]};
}

TEST(SlowFindDynamics, FindsWhatMovesInSimulatedScenes) {
  for (const char* scene : {"hall", "rooms"}) {
    std::vector<uint8_t> truth;
    const ScanSet scans = simulated_scans(scene, 7, 30, &truth);
    const Accuracy accuracy = accuracy_of(labels_of(scans), truth);
    EXPECT_GE(accuracy.static_kept, 0.96) << scene;
    EXPECT_GE(accuracy.dynamic_removed, 0.94) << scene;
  }
}

TEST(FindDynamics, AnyNumberOfThreadsFindsTheSame) {
  std::vector<uint8_t> truth;
  const ScanSet scans = simulated_scans("hall", 3, 9, &truth);
  set_num_threads(1);
  const std::vector<uint8_t> one = labels_of(scans);
  set_num_threads(3);
  const std::vector<uint8_t> three = labels_of(scans);
  set_num_threads(0);
  EXPECT_EQ(one, three);
  EXPECT_THAT(one, testing::Contains(1));
}

}  // namespace
}  // namespace cpplus
