#include "cpplus/features/boundary_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// A board of 2 x 1 m at z = 0, not turned, then moved into the oblique frame.
PointCloud board(double density, double noise_m, uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 1, 0}, density, noise_m, &random, &cloud);
  transform(oblique_frame(), &cloud);
  return cloud;
}

/// Edges in the frame of the board.
std::vector<MapEdge> borders_of(const PointCloud& cloud) {
  const VoxelMap map(cloud, {});
  auto edges = find_boundary_edges(map, segment_planes(map, {}), {});
  const Eigen::Isometry3d board_from_map = oblique_frame().inverse();
  for (MapEdge& edge : edges) {
    edge.start = board_from_map * edge.start;
    edge.end = board_from_map * edge.end;
    edge.inward_a = board_from_map.linear() * edge.inward_a;
  }
  return edges;
}

/// Distance outwards of the middle of an edge from the side of the board it is parallel to; NaN = the interior.
double outward_error(const MapEdge& edge) {
  const Vector3d middle = 0.5 * (edge.start + edge.end);
  double best = std::nan("");
  for (const double distance : {-middle.x(), middle.x() - 2, -middle.y(), middle.y() - 1}) {
    if (!(std::abs(distance) >= std::abs(best))) best = distance;
  }
  return std::abs(best) < 0.1 ? best : std::nan("");
}

TEST(BoundaryEdges, BordersOfABoardAreWhereTheyAre) {
  // Density -> bound of the mean error: points spread at random, the correction for spacing is only half (see docs).
  for (const auto& [density, bound] : {std::pair(8000.0, 0.004), std::pair(2000.0, 0.008), std::pair(800.0, 0.014)}) {
    double sum = 0.0;
    double length = 0.0;
    for (const uint64_t seed : {1u, 2u, 3u}) {
      for (const MapEdge& edge : borders_of(board(density, 0.01, seed))) {
        const double error = outward_error(edge);
        ASSERT_FALSE(std::isnan(error)) << "an edge in the interior";
        EXPECT_LT(std::abs(error), 0.03);
        sum += error * edge.length();
        length += edge.length();
      }
    }
    EXPECT_NEAR(sum / length, 0.0, bound) << "density " << density;
    EXPECT_GT(length, 3 * 0.7 * 6.0) << "density " << density;
    EXPECT_LT(length, 3 * 1.05 * 6.0) << "density " << density;
  }
}

TEST(BoundaryEdges, PointInwardsAndKnowTheirPlane) {
  const auto edges = borders_of(board(4000, 0.01, 5));
  ASSERT_FALSE(edges.empty());
  for (const MapEdge& edge : edges) {
    EXPECT_EQ(edge.kind, MapEdgeKind::kBoundary);
    EXPECT_GT(edge.inward_a.dot(Vector3d(1, 0.5, 0) - edge.start), 0.0);
    EXPECT_NEAR(edge.inward_a.norm(), 1.0, 1e-9);
    EXPECT_NEAR(edge.inward_a.dot(edge.direction()), 0.0, 0.03);
    EXPECT_GT(edge.covariance.trace(), 0.0);
  }
}

TEST(BoundaryEdges, AHoleHasBordersThatPointAway) {
  Random random(6);
  PointCloud cloud;
  add_surface({0, 0, 0}, {2, 0, 0}, {0, 0.6, 0}, 4000, 0.01, &random, &cloud);
  add_surface({0, 1.4, 0}, {2, 0, 0}, {0, 0.6, 0}, 4000, 0.01, &random, &cloud);
  add_surface({0, 0.6, 0}, {0.6, 0, 0}, {0, 0.8, 0}, 4000, 0.01, &random, &cloud);
  add_surface({1.4, 0.6, 0}, {0.6, 0, 0}, {0, 0.8, 0}, 4000, 0.01, &random, &cloud);
  transform(oblique_frame(), &cloud);
  double length = 0.0;
  for (const MapEdge& edge : borders_of(cloud)) {
    const Vector3d from_middle = 0.5 * (edge.start + edge.end) - Vector3d(1, 1, 0);
    if (from_middle.head<2>().cwiseAbs().maxCoeff() > 0.6) continue;
    EXPECT_NEAR(from_middle.head<2>().cwiseAbs().maxCoeff(), 0.4, 0.02);
    EXPECT_GT(edge.inward_a.dot(from_middle), 0.0);
    length += edge.length();
  }
  EXPECT_GT(length, 0.7 * 4 * 0.8);
}

TEST(BoundaryEdges, SparseBordersAreLeftOut) { EXPECT_TRUE(borders_of(board(100, 0.01, 7)).empty()); }

TEST(BoundaryEdges, ARoundBorderBecomesChordsBesideIt) {
  Random random(8);
  PointCloud cloud;
  while (cloud.size() < 6000) {
    const Vector3d x(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0.005 * random.normal());
    if (x.head<2>().norm() < 0.4) cloud.positions.push_back((oblique_frame() * x).cast<float>());
  }
  for (const MapEdge& edge : borders_of(cloud)) {
    EXPECT_NEAR(edge.start.head<2>().norm(), 0.4, 0.03);
    EXPECT_NEAR(edge.end.head<2>().norm(), 0.4, 0.03);
    EXPECT_NEAR((0.5 * (edge.start + edge.end)).head<2>().norm(), 0.4, 0.03);
  }
}

TEST(BoundaryEdges, OffOrEmptyGivesNone) {
  const VoxelMap map(board(4000, 0.01, 9), {});
  BoundaryEdgeOptions off;
  off.enabled = false;
  EXPECT_TRUE(find_boundary_edges(map, segment_planes(map, {}), off).empty());
  EXPECT_TRUE(borders_of(PointCloud{}).empty());
}

TEST(BoundaryEdges, RejectsOptionsOutOfRange) {
  const VoxelMap map(PointCloud{}, {});
  const auto rejects = [&](auto change) {
    BoundaryEdgeOptions options;
    change(options);
    EXPECT_THROW(find_boundary_edges(map, {}, options), Error);
  };
  rejects([](auto& o) { o.min_length_m = 0.0; });
  rejects([](auto& o) { o.max_length_m = std::nan(""); });
  rejects([](auto& o) { o.min_free_angle_deg = 360.0; });
  rejects([](auto& o) { o.max_outside_ratio = 1.1; });
  rejects([](auto& o) { o.max_spacing_m = 0.0; });
  rejects([](auto& o) { o.sigma_m = 0.0; });
}

}  // namespace
}  // namespace cpplus
