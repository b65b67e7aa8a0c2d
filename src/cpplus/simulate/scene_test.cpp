#include "cpplus/simulate/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpplus/core/error.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/tracer.h"
#include "cpplus/simulate/true_edges.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, HasPlanarUnitFacesWithMaterials) {
  const Scene scene = build_scene(GetParam(), 3);
  ASSERT_GT(scene.mesh.faces.size(), 50u);
  for (const MeshFace& face : scene.mesh.faces) {
    ASSERT_LT(face.material, scene.materials.size());
    ASSERT_LT(face.object, scene.objects.size());
    ASSERT_NEAR(face.normal.norm(), 1.0f, 1e-4f);
    for (const Vector3f& corner : face.corners) {
      ASSERT_NEAR(face.normal.dot(corner - face.corners[0]), 0.0f, 2e-4f);
    }
  }
}

TEST_P(EveryScene, TheWayIsClearAndSeesTheScene) {
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    const Scene scene = build_scene(GetParam(), seed);
    const Tracer tracer(scene);
    const Path path(scene.way);
    EXPECT_GT(path.duration_s(), 5.0);
    EXPECT_LT(path.duration_s(), 120.0);
    for (double time = 0.0; time < path.duration_s(); time += 0.5) {
      const Rigid3 pose = path.map_from_lidar(time);
      size_t near = 0;
      size_t seen_from_inside = 0;
      constexpr int kRays = 72;
      for (int i = 0; i < kRays; ++i) {
        const double angle = 2.0 * M_PI * i / kRays;
        const Vector3d ray = pose.rotation * Vector3d(std::cos(angle), std::sin(angle), 0.0);
        const auto hit = tracer.trace_static(pose.translation.cast<float>(), ray.cast<float>());
        if (!hit) continue;
        if (hit->range < 0.25f) ++near;
        if (hit->normal.dot(ray.cast<float>()) > 0.0f) ++seen_from_inside;
      }
      ASSERT_LT(near, 8u) << "seed " << seed << " at " << time << " s";
      ASSERT_LT(seen_from_inside, 8u) << "seed " << seed << " at " << time << " s";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scene, EveryScene, testing::ValuesIn(scene_names()),
                         [](const auto& instance) { return instance.param; });

TEST(Scene, ACorridorHasEdgesAlongItsAxisOnlyButForTheEnds) {
  const Scene scene = build_scene("corridor", 2);
  const auto edges = find_true_edges(Tracer(scene));
  double length = 0.0;
  for (const TrueEdge& edge : edges) length = std::max({length, edge.begin.x(), edge.end.x()});
  EXPECT_GT(length, 50.0);
  size_t along = 0;
  for (const TrueEdge& edge : edges) {
    if (std::abs((edge.end - edge.begin).normalized().x()) > 0.9999) {
      ++along;
      continue;
    }
    const double to_end = std::min(edge.begin.x(), length - edge.begin.x());
    EXPECT_LT(to_end, 5.0) << edge.begin.transpose() << " - " << edge.end.transpose();
  }
  EXPECT_GE(along, 8u);
}

TEST(Scene, UnknownNameIsNamed) {
  try {
    build_scene("moon", 1);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("moon"), std::string::npos);
  }
}

TEST(Path, IsSmoothAndWalksAtTheStatedSpeed) {
  const Scene scene = build_scene("hall", 1);
  const Path path(scene.way);
  constexpr double kStep = 1e-3;
  double length = 0.0;
  for (double time = kStep; time + kStep < path.duration_s(); time += kStep) {
    const Rigid3 before = path.map_from_lidar(time - kStep);
    const Rigid3 now = path.map_from_lidar(time);
    const Rigid3 after = path.map_from_lidar(time + kStep);
    length += (after.translation - now.translation).head<2>().norm();
    // No jumps of velocity: the second difference stays small.
    ASSERT_LT((after.translation - 2.0 * now.translation + before.translation).norm() / (kStep * kStep), 8.0);
    ASSERT_LT(rotation_angle_between(now, after) / kStep, 2.5);
  }
  EXPECT_NEAR(length / path.duration_s(), scene.way.speed_mps, 0.35 * scene.way.speed_mps);
}

TEST(MovingBody, WalksToAndFroAndFacesItsWay) {
  MovingBody body;
  body.path = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}};
  body.speed_mps = 1.0;
  EXPECT_LT((body.map_from_body(1.0).translation - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((body.map_from_body(4.0).translation - Vector3d(3, 1, 0)).norm(), 1e-12);
  EXPECT_LT((body.map_from_body(4.0).rotation * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((body.map_from_body(8.0).translation - Vector3d(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((body.map_from_body(8.0).rotation * Vector3d::UnitX() + Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((body.map_from_body(10.5).translation - Vector3d(0.5, 0, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace cpplus
