#include "cpplus/visibility/silhouettes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/visibility/point_spacing.h"
#include "cpplus/visibility/scene_test_util.h"

namespace cpplus {
namespace {

Camera pinhole() { return Camera(CameraModel::kPinhole, 1024, 768, {667, 667, 511.5, 383.5}); }

// A view in which no plane hides anything.
PlaneBuffer open_view(const Camera& camera, const Rigid3& camera_from_map) {
  PlaneBuffer view;
  view.camera = camera;
  view.camera_from_map = camera_from_map;
  return view;
}

std::vector<MapEdge> silhouettes_of(const PointCloud& cloud, const Camera& camera = pinhole(),
                                    const Rigid3& camera_from_map = Rigid3()) {
  const VoxelMap map(cloud, {});
  SilhouetteOptions options;
  options.enabled = true;
  return find_silhouettes(map, leaf_point_spacing(map), open_view(camera, camera_from_map), options);
}

// A wall of 20 x 16 m at z = 8, a point every 3 cm.
PointCloud wall() {
  Random random(1);
  PointCloud cloud;
  add_rectangle({-10, -8, 8}, {20, 0, 0}, {0, 16, 0}, 0.03, 0.01, &random, &cloud);
  return cloud;
}

double total_length(const std::vector<MapEdge>& edges) {
  double length = 0.0;
  for (const MapEdge& edge : edges) length += edge.length();
  return length;
}

TEST(FindSilhouettes, ABoardBeforeAWallHasItsFourSides) {
  Random random(2);
  PointCloud cloud = wall();
  add_rectangle({-1, -0.8, 4}, {2, 0, 0}, {0, 1.6, 0}, 0.015, 0.01, &random, &cloud);
  const std::vector<MapEdge> edges = silhouettes_of(cloud);
  EXPECT_GT(total_length(edges), 0.85 * 7.2);
  EXPECT_LT(total_length(edges), 1.05 * 7.2);
  for (const MapEdge& edge : edges) {
    EXPECT_EQ(edge.kind, MapEdgeKind::kSilhouette);
    for (const Eigen::Vector3d& x : {edge.start, edge.end}) {
      const double off_x = std::abs(std::abs(x.x()) - 1.0);
      const double off_y = std::abs(std::abs(x.y()) - 0.8);
      EXPECT_LT(std::min(off_x, off_y), 0.015) << x.transpose();
      EXPECT_NEAR(x.z(), 4.0, 0.05);
    }
    const Eigen::Vector3d middle = 0.5 * (edge.start + edge.end);
    EXPECT_LT(edge.inward_a.dot(middle - Eigen::Vector3d(0, 0, 4)), 0.0) << "towards the board";
    EXPECT_NEAR(edge.direction().cwiseAbs().maxCoeff(), 1.0, 2e-2);
    const double sigma = std::sqrt(edge.inward_a.dot(edge.covariance * edge.inward_a));
    EXPECT_GT(sigma, 0.004);
    EXPECT_LT(sigma, 0.03);
  }
}

TEST(FindSilhouettes, APoleHasItsTwoSidesWhateverTheViewingDirection) {
  Random random(3);
  PointCloud cloud = wall();
  for (int i = 0; i < 8000; ++i) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector3d x(0.1 * std::cos(angle), random.uniform(-1.5, 1.5), 4 + 0.1 * std::sin(angle));
    cloud.positions.push_back(x.cast<float>());
  }
  // From straight ahead, and from 1 m to the right.
  for (const double shift : {0.0, 1.0}) {
    Rigid3 camera_from_map;
    camera_from_map.translation.x() = -shift;
    const std::vector<MapEdge> edges = silhouettes_of(cloud, pinhole(), camera_from_map);
    EXPECT_GT(total_length(edges), 4.5) << shift;
    int left = 0;
    for (const MapEdge& edge : edges) {
      if (std::abs(edge.direction().y()) < 0.9) continue;  // its two ends
      // The tangent rays pass the axis at the radius.
      const Eigen::Vector3d ray = 0.5 * (edge.start + edge.end) - Eigen::Vector3d(shift, 0, 0);
      const Eigen::Vector2d flat = Eigen::Vector2d(ray.x(), ray.z()).normalized();
      const double passes = flat.x() * 4 + flat.y() * shift;
      EXPECT_NEAR(std::abs(passes), 0.1, 0.012) << shift;
      left += passes > 0;
    }
    EXPECT_GT(left, 2) << shift;
    EXPECT_LT(left, static_cast<int>(edges.size()) - 2) << shift;
  }
}

TEST(FindSilhouettes, SurfacesThatGoOnHaveNone) {
  Random random(4);
  PointCloud cloud = wall();
  add_rectangle({-10, 1.6, 1}, {20, 0, 0}, {0, 0, 7}, 0.03, 0.01, &random, &cloud);  // the floor
  EXPECT_TRUE(silhouettes_of(cloud).empty());
}

TEST(FindSilhouettes, TheBorderOfALidarShadowIsNone) {
  // What casts the shadow stands before the wall, a little beside it as seen from the camera.
  Random random(5);
  PointCloud cloud;
  add_rectangle({-10, -8, 8}, {10, 0, 0}, {0, 16, 0}, 0.03, 0.01, &random, &cloud);
  add_rectangle({2, -8, 8}, {8, 0, 0}, {0, 16, 0}, 0.03, 0.01, &random, &cloud);
  add_rectangle({0.5, -1, 4}, {1, 0, 0}, {0, 2, 0}, 0.015, 0.01, &random, &cloud);
  for (const MapEdge& edge : silhouettes_of(cloud)) EXPECT_NEAR(edge.start.z(), 4.0, 0.1);
}

TEST(FindSilhouettes, ARaggedOutlineIsNone) {
  Random random(6);
  PointCloud cloud = wall();
  for (int i = 0; i < 40000; ++i) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    // A crown of twigs 6 to 10 cm apart, up to 20 cm longer or shorter than the next.
    const double twig = 0.1 * std::sin(61 * angle) + 0.1 * std::sin(105 * angle + 1);
    const double radius = (1.0 + twig) * std::sqrt(random.uniform(0, 1));
    const Eigen::Vector3d x(radius * std::cos(angle), radius * std::sin(angle), random.uniform(3.7, 4.3));
    cloud.positions.push_back(x.cast<float>());
  }
  EXPECT_LT(total_length(silhouettes_of(cloud)), 0.5);
}

TEST(FindSilhouettes, AFisheyeSeesThemToo) {
  Random random(7);
  PointCloud cloud = wall();
  add_rectangle({2.5, -0.8, 3}, {1, 0, 0}, {0, 1.6, 0}, 0.015, 0.01, &random, &cloud);
  const Camera fisheye(CameraModel::kOpenCvFisheye, 900, 900, {400, 400, 449.5, 449.5, 0, 0, 0, 0});
  const std::vector<MapEdge> edges = silhouettes_of(cloud, fisheye);
  EXPECT_GT(total_length(edges), 3.5);
  for (const MapEdge& edge : edges) {
    const Eigen::Vector3d middle = 0.5 * (edge.start + edge.end) - Eigen::Vector3d(3, 0, 3);
    EXPECT_NEAR(std::max(std::abs(middle.x()) - 0.5, std::abs(middle.y()) - 0.8), 0.0, 0.02);
  }
}

TEST(FindSilhouettes, ThreadsDoNotChangeThem) {
  Random random(8);
  PointCloud cloud = wall();
  add_rectangle({-1, -0.8, 4}, {2, 0, 0}, {0, 1.6, 0}, 0.015, 0.01, &random, &cloud);
  const std::vector<MapEdge> one = silhouettes_of(cloud);
  std::vector<std::vector<MapEdge>> several(4);
  parallel_for_each(several.size(), [&](size_t i) { several[i] = silhouettes_of(cloud); });
  for (const std::vector<MapEdge>& edges : several) {
    ASSERT_EQ(edges.size(), one.size());
    for (size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(edges[i].start, one[i].start);
      EXPECT_EQ(edges[i].covariance, one[i].covariance);
    }
  }
}

TEST(FindSilhouettes, AnEmptyMapAndTheSwitchGiveNone) {
  EXPECT_TRUE(find_silhouettes(VoxelMap(), {}, open_view(pinhole(), Rigid3()), {}).empty());
  Random random(9);
  PointCloud cloud = wall();
  add_rectangle({-1, -0.8, 4}, {2, 0, 0}, {0, 1.6, 0}, 0.015, 0.01, &random, &cloud);
  const VoxelMap map(cloud, {});
  SilhouetteOptions options;
  options.enabled = false;
  EXPECT_TRUE(find_silhouettes(map, leaf_point_spacing(map), open_view(pinhole(), Rigid3()), options).empty());
}

TEST(SilhouetteOptions, ValuesOutOfRangeAreErrors) {
  SilhouetteOptions options;
  EXPECT_NO_THROW(options.validate());
  options.cell_px = 0.5;
  EXPECT_THROW(options.validate(), Error);
}

}  // namespace
}  // namespace cpplus
