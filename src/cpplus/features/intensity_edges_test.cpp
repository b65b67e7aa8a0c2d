#include "cpplus/features/intensity_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/cloud/point_map.h"
#include "cpplus/core/error.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// A wall of 3 x 2 m whose right part, beyond x = 1.2, is brighter; intensities have noise.
PointCloud painted_wall(double dark, double bright, double intensity_noise, uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  add_surface({0, 0, 0}, {3, 0, 0}, {0, 2, 0}, 3000, 0.01, &random, &cloud);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const double value = cloud.positions[i].x() > 1.2f ? bright : dark;
    cloud.intensities[i] = static_cast<float>(value + intensity_noise * random.normal());
  }
  transform(oblique_frame(), &cloud);
  return cloud;
}

/// Edges in the frame of the wall.
std::vector<MapEdge> edges_of(const PointCloud& cloud, const std::vector<float>& intensities) {
  const VoxelMap map(cloud, {});
  auto edges = find_intensity_edges(map, in_map_order(map, intensities), segment_planes(map, {}), {});
  const Eigen::Isometry3d wall_from_map = oblique_frame().inverse();
  for (MapEdge& edge : edges) {
    edge.start = wall_from_map * edge.start;
    edge.end = wall_from_map * edge.end;
    edge.inward_a = wall_from_map.linear() * edge.inward_a;
  }
  return edges;
}

TEST(IntensityEdges, StripesOfSingleLasersAreNone) {
  // Rings of 10 cm that each laser measures in its own way, as steep as the step of a painted wall.
  PointCloud cloud = painted_wall(60, 60, 0.0, 5);
  const Eigen::Isometry3d wall_from_map = oblique_frame().inverse();
  for (size_t i = 0; i < cloud.size(); ++i) {
    const int ring = static_cast<int>((wall_from_map * cloud.point(i)).x() / 0.1);
    cloud.intensities[i] = 60.0f + 60.0f * static_cast<float>(ring * 7 % 5) / 4.0f;
  }
  double length = 0.0;
  for (const MapEdge& edge : edges_of(cloud, cloud.intensities)) length += edge.length();
  // 29 borders of 2 m. At the ends of the wall too few stripes are in view.
  EXPECT_LT(length, 6.0);
}

TEST(IntensityEdges, AStepIsFoundWhereItIs) {
  for (const double noise : {0.0, 8.0}) {
    const PointCloud cloud = painted_wall(60, 120, noise, 1);
    double length = 0.0;
    for (const MapEdge& edge : edges_of(cloud, cloud.intensities)) {
      EXPECT_EQ(edge.kind, MapEdgeKind::kIntensity);
      EXPECT_NEAR(edge.start.x(), 1.2, 0.015);
      EXPECT_NEAR(edge.end.x(), 1.2, 0.015);
      EXPECT_NEAR(0.5 * (edge.start.x() + edge.end.x()), 1.2, 0.006);
      EXPECT_GT(edge.inward_a.x(), 0.99);  // towards the brighter side
      length += edge.length();
    }
    EXPECT_NEAR(length, 2.0, 0.4) << "noise " << noise;
  }
}

TEST(IntensityEdges, NoiseAndFaintStepsGiveNone) {
  const PointCloud even = painted_wall(100, 100, 15, 2);
  EXPECT_TRUE(edges_of(even, even.intensities).empty());
  const PointCloud faint = painted_wall(100, 112, 2, 3);
  EXPECT_TRUE(edges_of(faint, faint.intensities).empty());
}

TEST(IntensityEdges, OffOrWithoutIntensitiesThereAreNone) {
  const PointCloud cloud = painted_wall(60, 120, 2, 4);
  EXPECT_TRUE(edges_of(cloud, {}).empty());
  EXPECT_TRUE(edges_of(PointCloud{}, {}).empty());
  const VoxelMap map(cloud, {});
  IntensityEdgeOptions off;
  off.enabled = false;
  EXPECT_TRUE(find_intensity_edges(map, in_map_order(map, cloud.intensities), segment_planes(map, {}), off).empty());
}

TEST(IntensityEdges, RejectsOptionsOutOfRange) {
  const VoxelMap map(PointCloud{}, {});
  const auto rejects = [&](auto change) {
    IntensityEdgeOptions options;
    change(options);
    EXPECT_THROW(find_intensity_edges(map, {}, {}, options), Error);
  };
  rejects([](auto& o) { o.min_length_m = 0.0; });
  rejects([](auto& o) { o.max_length_m = std::nan(""); });
  rejects([](auto& o) { o.min_contrast = 2.0; });
  rejects([](auto& o) { o.min_contrast_sigmas = 0.0; });
  rejects([](auto& o) { o.sigma_m = 0.0; });
}

}  // namespace
}  // namespace cpplus
