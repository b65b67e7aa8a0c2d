#include "cpplus/features/crease_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/features/test_surfaces.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

struct Line {
  Vector3d start;
  Vector3d end;
  Vector3d direction() const { return (end - start).normalized(); }
  double distance(const Vector3d& x) const { return (x - start).cross(direction()).norm(); }
  double along(const Vector3d& x) const { return (x - start).dot(direction()); }
};

/// The corner of a room: a floor of 3 x 3 m and two walls 2.5 m high, in the oblique frame.
PointCloud room_corner(double density, double noise_m, uint64_t seed) {
  Random random(seed);
  PointCloud cloud;
  add_surface({0, 0, 0}, {3, 0, 0}, {0, 3, 0}, density, noise_m, &random, &cloud);
  add_surface({0, 0, 0}, {3, 0, 0}, {0, 0, 2.5}, density, noise_m, &random, &cloud);
  add_surface({0, 0, 0}, {0, 3, 0}, {0, 0, 2.5}, density, noise_m, &random, &cloud);
  transform(oblique_frame(), &cloud);
  return cloud;
}

std::vector<Line> room_corner_lines() {
  const Eigen::Isometry3d f = oblique_frame();
  const Vector3d o = f * Vector3d(0, 0, 0);
  return {{o, f * Vector3d(3, 0, 0)}, {o, f * Vector3d(0, 3, 0)}, {o, f * Vector3d(0, 0, 2.5)}};
}

std::vector<MapEdge> creases_of(const PointCloud& cloud) {
  const VoxelMap map(cloud, {});
  return find_crease_edges(map, segment_planes(map, {}), {});
}

const Line& nearest(const std::vector<Line>& lines, const MapEdge& edge) {
  return *std::min_element(lines.begin(), lines.end(), [&](const Line& a, const Line& b) {
    return std::abs(a.direction().dot(edge.direction())) > std::abs(b.direction().dot(edge.direction()));
  });
}

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / M_PI;
}

TEST(CreaseEdges, ExactSurfacesGiveTheExactCorner) {
  const auto lines = room_corner_lines();
  const auto edges = creases_of(room_corner(2000, 0.0, 1));
  double length = 0.0;
  for (const MapEdge& edge : edges) {
    const Line& line = nearest(lines, edge);
    EXPECT_LT(line.distance(edge.start), 1e-4);
    EXPECT_LT(line.distance(edge.end), 1e-4);
    EXPECT_LT(angle_deg(line.direction(), edge.direction()), 0.02);
    length += edge.length();
  }
  EXPECT_NEAR(length, 3 + 3 + 2.5, 0.4);
}

TEST(CreaseEdges, TwoCentimetresOfNoiseMoveACornerByMillimetres) {
  const auto lines = room_corner_lines();
  std::vector<double> distances;
  std::vector<double> angles;
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const auto edges = creases_of(room_corner(2000, 0.02, seed));
    std::vector<double> length(3, 0.0);
    for (const MapEdge& edge : edges) {
      const Line& line = nearest(lines, edge);
      distances.push_back(line.distance(0.5 * (edge.start + edge.end)));
      angles.push_back(angle_deg(line.direction(), edge.direction()));
      length[static_cast<size_t>(&line - lines.data())] += edge.length();
    }
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(length[k], (lines[k].end - lines[k].start).norm(), 0.25);
  }
  ASSERT_GE(distances.size(), 15u);
  std::sort(distances.begin(), distances.end());
  std::sort(angles.begin(), angles.end());
  EXPECT_LT(distances[distances.size() / 2], 0.003);
  EXPECT_LT(distances.back(), 0.008);
  EXPECT_LT(angles[angles.size() / 2], 0.2);
  EXPECT_LT(angles.back(), 0.8);
}

TEST(CreaseEdges, ASkirtingBoardAsThinAsTheNoiseMeetsTheFloorWhereItStands) {
  Random random(8);
  PointCloud cloud;
  constexpr double kThickness = 0.015;
  constexpr double kHeight = 0.1;
  add_surface({0, 0, 0}, {3, 0, 0}, {0, 3, 0}, 4000, 0.008, &random, &cloud);
  add_surface({0, 0, kHeight}, {3, 0, 0}, {0, 0, 2.4}, 6000, 0.015, &random, &cloud);
  add_surface({0, kThickness, 0}, {3, 0, 0}, {0, 0, kHeight}, 6000, 0.015, &random, &cloud);
  double length = 0.0;
  for (const MapEdge& edge : creases_of(cloud)) {
    EXPECT_GT(std::abs(edge.direction().x()), 0.999);
    EXPECT_NEAR(0.5 * (edge.start.y() + edge.end.y()), kThickness, 0.007);
    EXPECT_NEAR(0.5 * (edge.start.z() + edge.end.z()), 0.0, 0.002);
    length += edge.length();
  }
  EXPECT_GT(length, 2.5);
}

TEST(CreaseEdges, EndPointsAreThoseOfTheSurfaces) {
  // A step: floor, riser 1 m wide; the crease at the riser's foot is 1 m long although the floor goes on.
  Random random(4);
  PointCloud cloud;
  add_surface({-1, -1, 0}, {4, 0, 0}, {0, 3, 0}, 2500, 0.01, &random, &cloud);
  add_surface({0, 1, 0}, {1.5, 0, 0}, {0, 0, 1}, 2500, 0.01, &random, &cloud);
  transform(oblique_frame(), &cloud);
  const Line line{oblique_frame() * Vector3d(0, 1, 0), oblique_frame() * Vector3d(1.5, 1, 0)};
  double low = 1e9;
  double high = -1e9;
  for (const MapEdge& edge : creases_of(cloud)) {
    EXPECT_LT(line.distance(edge.start), 0.01);
    low = std::min({low, line.along(edge.start), line.along(edge.end)});
    high = std::max({high, line.along(edge.start), line.along(edge.end)});
  }
  EXPECT_NEAR(low, 0.0, 0.06);
  EXPECT_NEAR(high, 1.5, 0.06);
}

TEST(CreaseEdges, CovarianceDescribesTheErrors) {
  const auto lines = room_corner_lines();
  double sum = 0.0;
  int count = 0;
  CreaseEdgeOptions options;
  options.map_sigma_m = 0.0;  // this map is not distorted
  for (uint64_t seed = 10; seed < 16; ++seed) {
    const VoxelMap map(room_corner(1000, 0.02, seed), {});
    for (const MapEdge& edge : find_crease_edges(map, segment_planes(map, {}), options)) {
      const Line& line = nearest(lines, edge);
      const Vector3d middle = 0.5 * (edge.start + edge.end);
      const Vector3d error = middle - (line.start + line.along(middle) * line.direction());
      EXPECT_LT((edge.covariance * edge.direction()).norm(), 1e-9);
      // Two axes across the edge, in which the error is that of the two planes.
      const Vector3d u = edge.direction().unitOrthogonal();
      const Vector3d v = edge.direction().cross(u);
      Eigen::Matrix<double, 2, 3> across;
      across << u.transpose(), v.transpose();
      const Eigen::Matrix2d covariance = across * edge.covariance * across.transpose();
      const Eigen::Vector2d e = across * error;
      sum += e.dot(covariance.inverse() * e);
      ++count;
    }
  }
  ASSERT_GT(count, 25);
  // Chi-square of two degrees of freedom: 2 on average.
  EXPECT_GT(sum / count, 0.7);
  EXPECT_LT(sum / count, 5.0);
}

TEST(CreaseEdges, InwardDirectionsPointIntoTheSurfaces) {
  const Vector3d inside = oblique_frame() * Vector3d(1.5, 1.5, 1.25);
  const auto edges = creases_of(room_corner(2000, 0.005, 7));
  ASSERT_FALSE(edges.empty());
  for (const MapEdge& edge : edges) {
    EXPECT_EQ(edge.kind, MapEdgeKind::kCrease);
    EXPECT_NEAR(edge.inward_a.norm(), 1.0, 1e-9);
    EXPECT_NEAR(edge.inward_a.dot(edge.normal_a), 0.0, 0.01);
    EXPECT_GT(edge.inward_a.dot(inside - edge.start), 0.0);
    EXPECT_GT(edge.inward_b.dot(inside - edge.start), 0.0);
  }
}

TEST(CreaseEdges, ATableTopBeforeAWallDoesNotMeetIt) {
  Random random(8);
  PointCloud cloud;
  add_surface({-1, 1.1, -1}, {3, 0, 0}, {0, 0, 2}, 2500, 0.01, &random, &cloud);
  add_surface({0, 0, 0}, {1.2, 0, 0}, {0, 1, 0}, 2500, 0.01, &random, &cloud);
  EXPECT_TRUE(creases_of(cloud).empty());
  // Pushed to the wall it does.
  for (Eigen::Vector3f& x : cloud.positions) {
    if (std::abs(x.z()) < 0.05f && x.y() < 1.02f) x.y() += 0.1f;
  }
  EXPECT_FALSE(creases_of(cloud).empty());
}

TEST(CreaseEdges, PlanesThatCrossMakeNoCorner) {
  Random random(9);
  PointCloud cloud;
  add_surface({-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, 2500, 0.01, &random, &cloud);
  add_surface({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2500, 0.01, &random, &cloud);
  transform(oblique_frame(), &cloud);
  EXPECT_TRUE(creases_of(cloud).empty());
}

TEST(CreaseEdges, EmptyMapHasNone) { EXPECT_TRUE(creases_of(PointCloud{}).empty()); }

TEST(CreaseEdges, RejectsOptionsOutOfRange) {
  const VoxelMap map(PointCloud{}, {});
  const auto rejects = [&](auto change) {
    CreaseEdgeOptions options;
    change(options);
    EXPECT_THROW(find_crease_edges(map, {}, options), Error);
  };
  rejects([](auto& o) { o.min_angle_deg = 0.0; });
  rejects([](auto& o) { o.min_angle_deg = 91.0; });
  rejects([](auto& o) { o.min_length_m = 0.0; });
  rejects([](auto& o) { o.max_length_m = std::nan(""); });
  rejects([](auto& o) { o.support_distance_m = 0.0; });
  rejects([](auto& o) { o.max_gap_m = -1.0; });
  rejects([](auto& o) { o.fit_distance_m = 0.0; });
  rejects([](auto& o) { o.map_sigma_m = -0.1; });
}

}  // namespace
}  // namespace cpplus
