#include "cpplus/simulate/boards_along_way.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/simulate.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

bool sees_whole(const Tracer& tracer, const Vector3d& eye, const SceneCheckerboard& board) {
  for (const Vector3d& corner : board.corners) {
    const Vector3d ray = corner - eye;
    const auto hit = tracer.trace_static(eye.cast<float>(), ray.normalized().cast<float>());
    if (!hit || std::abs(hit->range - ray.norm()) > 0.01 || hit->normal.dot(ray.cast<float>()) > 0.0f) return false;
  }
  return true;
}

class BoardsAlongWay : public testing::TestWithParam<std::string> {};

TEST_P(BoardsAlongWay, StandBesideTheWayAndAreSeenFromIt) {
  for (const uint64_t seed : {1, 2, 3}) {
    Scene scene = build_scene(GetParam(), seed);
    const size_t before = scene.boards.size();
    add_boards_along_way(3, seed, &scene);
    ASSERT_LE(scene.boards.size(), before + 3);
    const Tracer tracer(scene);
    const Path path(scene.way);
    for (size_t b = before; b < scene.boards.size(); ++b) {
      const SceneCheckerboard& board = scene.boards[b];
      const Vector3d middle = 0.5 * (board.corners.front() + board.corners.back());
      int seen = 0;
      for (double time = 0.0; time < path.duration_s(); time += 0.25) {
        const Rigid3 map_from_lidar = path.map_from_lidar(time);
        const Vector2d apart = (map_from_lidar.translation - middle).head<2>();
        // 0.9 m, less what the tilt moves the plate's middle.
        EXPECT_GT(apart.norm(), 0.8) << "seed " << seed << ", board " << board.name << " at " << time << " s";
        const Vector3d in_lidar = inverse(map_from_lidar) * middle;
        const bool ahead = std::abs(std::atan2(in_lidar.y(), in_lidar.x())) < 0.45 && in_lidar.norm() < 7.0;
        if (ahead && sees_whole(tracer, map_from_lidar.translation, board)) ++seen;
      }
      EXPECT_GT(seen, 0) << "seed " << seed << ", board " << board.name;
    }
  }
}

TEST_P(BoardsAlongWay, AreTheSameForTheSameSeed) {
  Scene one = build_scene(GetParam(), 2);
  Scene two = build_scene(GetParam(), 2);
  add_boards_along_way(2, 7, &one);
  add_boards_along_way(2, 7, &two);
  ASSERT_EQ(one.boards.size(), two.boards.size());
  for (size_t b = 0; b < one.boards.size(); ++b) EXPECT_EQ(one.boards[b].corners, two.boards[b].corners);
}

INSTANTIATE_TEST_SUITE_P(Scene, BoardsAlongWay, testing::Values("rooms", "hall", "street", "corridor"),
                         [](const auto& instance) { return instance.param; });

TEST(BoardsAlongTheWay, ComeToScenesThatHaveNone) {
  for (const char* name : {"street", "corridor"}) {
    Scene scene = build_scene(name, 1);
    ASSERT_TRUE(scene.boards.empty()) << name;
    add_boards_along_way(2, 1, &scene);
    EXPECT_GE(scene.boards.size(), 1u) << name;
    EXPECT_LE(scene.boards.size(), 2u) << name;
  }
}

TEST(BoardsAlongTheWay, NoneAskedForLeavesTheScene) {
  Scene scene = build_scene("hall", 1);
  const Scene before = scene;
  add_boards_along_way(0, 1, &scene);
  EXPECT_EQ(scene.mesh.vertices, before.mesh.vertices);
  EXPECT_EQ(scene.boards.size(), before.boards.size());
}

TEST(BoardsAlongTheWay, AreInTheImagesOfASimulatedCorridor) {
  SimulateOptions options;
  options.scene = "corridor";
  options.width = 320;
  options.height = 240;
  options.images = 4;
  options.scans = 2;
  options.lidar.rings = 4;
  options.render.samples_per_pixel = 1;
  options.boards = 2;
  EXPECT_FALSE(simulate_world(options).board_views.empty());
  options.boards = 27;
  EXPECT_THROW(simulate_world(options), UsageError);
}

}  // namespace
}  // namespace cpplus
