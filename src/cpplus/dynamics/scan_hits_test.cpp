#include "cpplus/dynamics/scan_hits.h"

#include <gmock/gmock.h>

#include <limits>
#include <map>

#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Eigen::Vector3f;

void add_scan(ScanSet* scans, const std::vector<Vector3f>& points) {
  for (const Vector3f& point : points) scans->points.positions.push_back(point);
  scans->first_point.push_back(scans->points.size());
  scans->sensors_in_map.emplace_back(0.0, 0.0, 0.0);
}

/// Scans of all sizes, also empty ones, with points that are not finite.
ScanSet random_scans(size_t num_scans) {
  Random random(4);
  ScanSet scans;
  for (size_t scan = 0; scan < num_scans; ++scan) {
    std::vector<Vector3f> points;
    for (size_t i = 0; i < scan % 7 * 700; ++i) {
      points.push_back(Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0.0).cast<float>());
      if (i % 100 == 99) points.back().x() = std::numeric_limits<float>::quiet_NaN();
    }
    add_scan(&scans, points);
  }
  return scans;
}

TEST(ScanOfPoint, FindsTheScanOfEveryPoint) {
  const ScanSet scans = random_scans(30);
  const ScanOfPoint scan_of_point(scans);
  for (uint32_t scan = 0; scan < scans.num_scans(); ++scan) {
    for (size_t i = scans.first_point[scan]; i < scans.first_point[scan + 1]; ++i) ASSERT_EQ(scan_of_point(i), scan);
  }
}

TEST(ScanHits, AreTheFirstPointsOfEachScanInEachLeaf) {
  ScanSet scans;
  add_scan(&scans, {{0.30f, 0.0f, 0.0f}, {0.01f, 0.01f, 0.01f}, {0.02f, 0.01f, 0.01f}});
  add_scan(&scans, {});
  add_scan(&scans, {{0.03f, 0.01f, 0.01f}});
  const VoxelMap map(scans.points, {});
  const ScanHits hits = find_scan_hits(map, scans);
  const auto inputs_of = [&](size_t scan) {
    std::vector<uint32_t> inputs;
    for (const LeafHit& hit : hits.of(scan)) inputs.push_back(map.input_index(hit.point));
    return inputs;
  };
  EXPECT_THAT(inputs_of(0), testing::ElementsAre(1, 0));  // by leaf
  EXPECT_THAT(inputs_of(1), testing::IsEmpty());
  EXPECT_THAT(inputs_of(2), testing::ElementsAre(3));
}

TEST(ScanHits, AreThoseOfAPlainSearchForAnyNumberOfThreads) {
  const ScanSet scans = random_scans(60);
  const VoxelMap map(scans.points, {});
  for (const int threads : {1, 3}) {
    set_num_threads(threads);
    const ScanHits hits = find_scan_hits(map, scans);
    set_num_threads(0);
    for (size_t scan = 0; scan < scans.num_scans(); ++scan) {
      std::map<uint32_t, size_t> first_in_leaf;
      for (size_t i = scans.first_point[scan]; i < scans.first_point[scan + 1]; ++i) {
        if (!scans.points.positions[i].allFinite()) continue;
        first_in_leaf.emplace(*map.find_leaf(scans.points.point(i)), i);
      }
      ASSERT_EQ(hits.of(scan).size(), first_in_leaf.size());
      auto expected = first_in_leaf.begin();
      for (const LeafHit& hit : hits.of(scan)) {
        ASSERT_EQ(hit.leaf, expected->first);
        ASSERT_EQ(map.input_index(hit.point), expected->second);
        ++expected;
      }
    }
  }
}

}  // namespace
}  // namespace cpplus
