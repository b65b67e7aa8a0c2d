#include "cpplus/render/surface_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

constexpr double kSpacingM = 0.02;
constexpr double kNoiseM = 0.01;

/// A slanted wall through (0, 0, 4), noisy, and a board of 1 m in front of it at z = 2. Axes of the camera.
const Eigen::Vector3d kWallNormal = Eigen::Vector3d(0.4, 0.2, -1.0).normalized();

struct World {
  PointCloud cloud;
  VoxelMap map;
  MapDiscs discs;
};

World make_world(double noise_m) {
  World world;
  Random random(3);
  std::vector<Eigen::Vector3f> normals;
  for (double x = -4; x <= 4; x += kSpacingM) {
    for (double y = -3; y <= 3; y += kSpacingM) {
      // n . (x, y, z) = n . (0, 0, 4)
      const double z = 4.0 - (kWallNormal.x() * x + kWallNormal.y() * y) / kWallNormal.z();
      const Eigen::Vector3d noise = noise_m * random.normal() * kWallNormal;
      world.cloud.positions.push_back((Eigen::Vector3d(x, y, z) + noise).cast<float>());
      normals.push_back(kWallNormal.cast<float>());
    }
  }
  for (double x = -0.5; x <= 0.5; x += kSpacingM) {
    for (double y = -0.5; y <= 0.5; y += kSpacingM) {
      world.cloud.positions.emplace_back(x, y, 2.0 + noise_m * random.normal());
      normals.push_back(Eigen::Vector3f::UnitZ());  // of either sign
    }
  }
  world.map = VoxelMap(world.cloud, {});
  world.discs.leaf_spacing_m.assign(world.map.num_nodes(world.map.leaf_layer()), static_cast<float>(kSpacingM));
  for (size_t i = 0; i < world.map.num_points(); ++i) world.discs.normals.push_back(normals[world.map.input_index(i)]);
  return world;
}

SurfaceView render(const World& world, const Camera& camera) {
  return render_surface(world.map, world.discs, camera, pixel_bearings(camera), Rigid3(), {});
}

/// Exact range along a bearing.
double true_range(const Eigen::Vector3d& bearing) {
  const double at_board = 2.0 / bearing.z();
  const Eigen::Vector3d on_board = at_board * bearing;
  if (std::abs(on_board.x()) <= 0.5 && std::abs(on_board.y()) <= 0.5) return at_board;
  return 4.0 * kWallNormal.z() / kWallNormal.dot(bearing);
}

const Camera kCamera(CameraModel::kSimpleRadial, 320, 240, {240, 159.5, 119.5, -0.05});

TEST(RenderSurface, RangesAreThoseOfTheSurface) {
  const SurfaceView view = render(make_world(kNoiseM), kCamera);
  std::vector<double> errors;
  size_t num_empty = 0;
  size_t num_wrong = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double expected = true_range(*kCamera.unproject(Eigen::Vector2d(x, y)));
      const double range = static_cast<double>(view.range.at(x, y));
      if (range == 0.0) {
        ++num_empty;
        continue;
      }
      errors.push_back(std::abs(range - expected));
      num_wrong += errors.back() > 0.06 ? 1 : 0;
    }
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.5 * kNoiseM);  // the mean of several points
  EXPECT_LT(num_wrong, errors.size() / 100);            // outlines of the board only
  EXPECT_LT(num_empty, 320u * 240u / 40u);
}

TEST(RenderSurface, IsExactWithoutNoise) {
  const SurfaceView view = render(make_world(0.0), kCamera);
  const double expected = true_range(*kCamera.unproject({40, 200}));
  EXPECT_NEAR(view.range.at(40, 200), expected, 2e-4 * expected);
  EXPECT_NEAR(view.range.at(160, 120), true_range(*kCamera.unproject({160, 120})), 1e-3);
}

TEST(RenderSurface, NormalsPointToTheCamera) {
  const SurfaceView view = render(make_world(0.0), kCamera);
  EXPECT_LT((view.normals.at(30, 30) - kWallNormal.cast<float>()).norm(), 1e-3f);
  EXPECT_LT((view.normals.at(160, 120) - Eigen::Vector3f(0, 0, -1)).norm(), 1e-3f);
}

TEST(RenderSurface, NothingIsDrawnBeyondTheEndOfASurface) {
  World world = make_world(0.0);
  // The board alone.
  PointCloud board;
  for (const Eigen::Vector3f& x : world.cloud.positions) {
    if (x.z() == 2.0f) board.positions.push_back(x);
  }
  world.cloud = board;
  world.map = VoxelMap(board, {});
  world.discs.leaf_spacing_m.assign(world.map.num_nodes(world.map.leaf_layer()), static_cast<float>(kSpacingM));
  world.discs.normals.assign(world.map.num_points(), Eigen::Vector3f::UnitZ());
  const Camera camera(CameraModel::kPinhole, 320, 240, {240, 240, 159.5, 119.5});
  const SurfaceView view = render(world, camera);
  const double half_px = 240 * 0.5 / 2.0;
  for (int x = 0; x < 320; ++x) {
    const double beyond_px = std::abs(x - 159.5) - half_px;
    if (beyond_px > 1.5) {
      EXPECT_EQ(view.range.at(x, 120), 0.0f) << x;
    }
    if (beyond_px < -1.5) {
      EXPECT_NEAR(view.range.at(x, 120), 2.0f, 0.1f) << x;
    }
  }
  EXPECT_EQ(view.normals.at(5, 5), Eigen::Vector3f(0, 0, 0));
}

TEST(RenderSurface, DiscsWithoutANormalFaceTheCamera) {
  World world = make_world(0.0);
  for (Eigen::Vector3f& normal : world.discs.normals) normal.setZero();
  const SurfaceView view = render(world, kCamera);
  EXPECT_NEAR(view.range.at(160, 120), true_range(*kCamera.unproject({160, 120})), 0.01);
  EXPECT_EQ(view.normals.at(160, 120), Eigen::Vector3f(0, 0, 0));
}

TEST(RenderSurface, APanoramaHasNoSeam) {
  // A ball of 3 m around the camera.
  World world;
  std::vector<Eigen::Vector3f> normals;
  for (int i = 0; i < 60000; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / 60000;  // golden spiral: evenly spread
    const double angle = i * M_PI * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d n(r * std::cos(angle), r * std::sin(angle), z);
    world.cloud.positions.push_back((3.0 * n).cast<float>());
    normals.push_back(n.cast<float>());
  }
  world.map = VoxelMap(world.cloud, {});
  world.discs.leaf_spacing_m.assign(world.map.num_nodes(world.map.leaf_layer()), 0.043f);
  for (size_t i = 0; i < world.map.num_points(); ++i) world.discs.normals.push_back(normals[world.map.input_index(i)]);
  const SurfaceView view = render(world, Camera(CameraModel::kEquirectangular, 256, 128, {256, 128}));
  for (int y = 4; y < 124; ++y) {
    for (const int x : {0, 1, 128, 254, 255}) EXPECT_NEAR(view.range.at(x, y), 3.0f, 0.01f) << x << " " << y;
  }
}

TEST(RenderSurface, IsTheSameForAnyNumberOfThreads) {
  const World world = make_world(kNoiseM);
  set_num_threads(1);
  const SurfaceView one = render(world, kCamera);
  set_num_threads(4);
  const SurfaceView four = render(world, kCamera);
  set_num_threads(0);
  EXPECT_EQ(one.range.pixels, four.range.pixels);
  EXPECT_TRUE(one.normals.pixels == four.normals.pixels);
}

}  // namespace
}  // namespace cpplus
