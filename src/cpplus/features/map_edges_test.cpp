#include "cpplus/features/map_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "cpplus/cloud/point_map.h"
#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// A box of 0.8 x 0.6 x 0.5 m on a floor before a painted wall: edges of all kinds.
PointCloud box_before_a_wall(uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  constexpr double kDensity = 2500;
  constexpr double kNoise = 0.01;
  add_surface({-1, -1, 0}, {3, 0, 0}, {0, 1, 0}, kDensity, kNoise, &random, &cloud);
  add_surface({-1, 0.6, 0}, {3, 0, 0}, {0, 1, 0}, kDensity, kNoise, &random, &cloud);
  add_surface({-1, 1.6, 0}, {1.5, 0, 0}, {0, 0, 2}, kDensity, kNoise, &random, &cloud, 50.0f);
  add_surface({0.5, 1.6, 0}, {1.5, 0, 0}, {0, 0, 2}, kDensity, kNoise, &random, &cloud, 120.0f);
  add_surface({0, 0, 0}, {0.8, 0, 0}, {0, 0, 0.5}, kDensity, kNoise, &random, &cloud);
  add_surface({0, 0.6, 0}, {0.8, 0, 0}, {0, 0, 0.5}, kDensity, kNoise, &random, &cloud);
  add_surface({0, 0, 0.5}, {0.8, 0, 0}, {0, 0.6, 0}, kDensity, kNoise, &random, &cloud);
  transform(oblique_frame(), &cloud);
  return cloud;
}

std::vector<MapEdge> edges_of(const PointCloud& cloud) {
  const VoxelMap map(cloud, {});
  return find_map_edges(map, in_map_order(map, cloud.intensities), segment_planes(map, {}), {});
}

TEST(MapEdges, ASceneHasEdgesOfAllKindsInOrder) {
  const auto edges = edges_of(box_before_a_wall(1));
  std::vector<int> kinds;
  for (const MapEdge& edge : edges) kinds.push_back(static_cast<int>(edge.kind));
  for (const MapEdgeKind kind : {MapEdgeKind::kCrease, MapEdgeKind::kBoundary, MapEdgeKind::kIntensity}) {
    EXPECT_GT(std::count(kinds.begin(), kinds.end(), static_cast<int>(kind)), 0) << static_cast<int>(kind);
  }
  // Creases, intensity edges, boundaries; a group is of one kind.
  std::set<uint32_t> seen;
  for (size_t i = 0; i < edges.size(); ++i) {
    if (i > 0 && edges[i].group == edges[i - 1].group) {
      EXPECT_EQ(edges[i].kind, edges[i - 1].kind);
    } else {
      EXPECT_TRUE(seen.insert(edges[i].group).second) << "group " << edges[i].group << " is not in one piece";
    }
  }
}

TEST(MapEdges, NoBoundaryRunsAlongACrease) {
  const auto edges = edges_of(box_before_a_wall(2));
  for (const MapEdge& border : edges) {
    if (border.kind != MapEdgeKind::kBoundary) continue;
    for (const MapEdge& crease : edges) {
      if (crease.kind != MapEdgeKind::kCrease) continue;
      const Vector3d middle = 0.5 * (border.start + border.end);
      const double along = crease.direction().dot(middle - crease.start);
      const bool beside =
          std::abs(crease.direction().dot(border.direction())) > 0.99 && along > 0 && along < crease.length();
      if (!beside) continue;
      EXPECT_GT((middle - crease.start - along * crease.direction()).norm(), 0.03);
    }
  }
}

TEST(MapEdges, OneThreadAndTwoGiveTheSame) {
  const PointCloud cloud = box_before_a_wall(3);
  set_num_threads(1);
  const auto one = edges_of(cloud);
  set_num_threads(2);
  const auto two = edges_of(cloud);
  set_num_threads(0);
  ASSERT_EQ(one.size(), two.size());
  ASSERT_FALSE(one.empty());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].kind, two[i].kind);
    EXPECT_EQ(one[i].start, two[i].start);
    EXPECT_EQ(one[i].end, two[i].end);
    EXPECT_EQ(one[i].covariance, two[i].covariance);
    EXPECT_EQ(one[i].group, two[i].group);
  }
}

TEST(MapEdges, EmptyMapHasNone) { EXPECT_TRUE(edges_of(PointCloud{}).empty()); }

TEST(MapEdges, RejectsOptionsOutOfRange) {
  const VoxelMap map(PointCloud{}, {});
  MapEdgeOptions options;
  options.min_separation_m = -1.0;
  EXPECT_THROW(find_map_edges(map, {}, {}, options), Error);
  options = {};
  options.crease.min_length_m = 0.0;
  EXPECT_THROW(find_map_edges(map, {}, {}, options), Error);
}

}  // namespace
}  // namespace cpplus
