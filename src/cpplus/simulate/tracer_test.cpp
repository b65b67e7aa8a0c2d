#include "cpplus/simulate/tracer.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "cpplus/core/parallel.h"
#include "cpplus/simulate/test_scene.h"

namespace cpplus {
namespace {

using Eigen::Vector3f;

TEST(Tracer, RangeToAKnownWallIsExact) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  const auto square = tracer.trace_static(Vector3f::Zero(), Vector3f::UnitX());
  ASSERT_TRUE(square.has_value());
  EXPECT_NEAR(square->range, 2.0f, 1e-6f);
  EXPECT_EQ(square->face->object, 1u);
  EXPECT_NEAR(square->uv.x(), 0.5f, 1e-6f);
  EXPECT_NEAR(square->uv.y(), 0.5f, 1e-6f);
  // 45 degrees to the left passes the square and meets the wall at 3 sqrt(2).
  const auto wall = tracer.trace_static(Vector3f::Zero(), Vector3f(1, 1, 0).normalized());
  ASSERT_TRUE(wall.has_value());
  EXPECT_NEAR(wall->range, 3.0f * std::sqrt(2.0f), 1e-5f);
  EXPECT_TRUE(wall->normal.isApprox(Vector3f(-1, 0, 0), 1e-6f));
  EXPECT_FALSE(tracer.trace_static(Vector3f::Zero(), -Vector3f::UnitX()).has_value());
}

TEST(Tracer, LeavesTheProgramItsThreads) {
  set_num_threads(3);
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  EXPECT_EQ(num_threads(), 3);
  set_num_threads(0);
}

TEST(Tracer, PartsMakeUpOneScene) {
  const Scene whole = wall_and_square();
  // The wall and the square as meshes of their own, each with other materials.
  Mesh wall, square;
  MeshBuilder(&wall).add_quad({3.0, 20.0, -20.0}, {0.0, -40.0, 0.0}, {0.0, 0.0, 40.0}, 0);
  MeshBuilder(&square).add_quad({2.0, 0.5, -0.5}, {0.0, -1.0, 0.0}, {0.0, 0.0, 1.0}, 0);
  const std::vector<Material> of_wall = {whole.materials[0]}, of_square = {whole.materials[1]};
  const auto wall_part = std::make_shared<const TracedMesh>(wall, of_wall);
  const auto square_part = std::make_shared<const TracedMesh>(square, of_square);
  const Scene around;
  Tracer tracer(around, {wall_part, square_part});
  const Tracer whole_tracer(whole);
  for (double y = -1.0; y < 1.0; y += 0.013) {
    const Vector3f ray = Vector3f(1.0f, static_cast<float>(y), 0.1f).normalized();
    const auto hit = tracer.trace_static(Vector3f::Zero(), ray);
    const auto expected = whole_tracer.trace_static(Vector3f::Zero(), ray);
    ASSERT_TRUE(hit && expected);
    EXPECT_EQ(hit->range, expected->range);
    EXPECT_EQ(hit->part, expected->face->object);
    EXPECT_EQ(hit->material->emission, whole.materials[expected->face->material].emission);
  }
  EXPECT_TRUE(tracer.occluded_static(Vector3f::Zero(), Vector3f::UnitX(), 2.1f));
  tracer.set_parts({wall_part});
  EXPECT_FALSE(tracer.occluded_static(Vector3f::Zero(), Vector3f::UnitX(), 2.1f));
  EXPECT_NEAR(tracer.trace_static(Vector3f::Zero(), Vector3f::UnitX())->range, 3.0f, 1e-6f);
  tracer.set_parts({});
  EXPECT_FALSE(tracer.trace_static(Vector3f::Zero(), Vector3f::UnitX()).has_value());
}

TEST(Tracer, OcclusionStopsAtTheGivenRange) {
  const Scene scene = wall_and_square();
  const Tracer tracer(scene);
  EXPECT_TRUE(tracer.occluded_static(Vector3f::Zero(), Vector3f::UnitX(), 2.1f));
  EXPECT_FALSE(tracer.occluded_static(Vector3f::Zero(), Vector3f::UnitX(), 1.9f));
}

TEST(Tracer, AMovingBodyIsMetWhereItIsAtThatInstant) {
  Scene scene = wall_and_square();
  MovingBody body;
  MeshBuilder(&body.mesh).add_box({-0.1, -0.1, -1.0}, {0.1, 0.1, 1.0}, 0);
  body.path = {{1.0, -2.0, 0.0}, {1.0, 2.0, 0.0}};
  body.speed_mps = 1.0;
  scene.bodies.push_back(body);
  const Tracer tracer(scene);
  const auto before = tracer.trace(Vector3f::Zero(), Vector3f::UnitX(), body_poses(scene, 0.0));
  const auto during = tracer.trace(Vector3f::Zero(), Vector3f::UnitX(), body_poses(scene, 2.0));
  ASSERT_TRUE(before && during);
  EXPECT_EQ(before->body, -1);
  EXPECT_NEAR(before->range, 2.0f, 1e-6f);
  EXPECT_EQ(during->body, 0);
  EXPECT_NEAR(during->range, 0.9f, 1e-5f);
  EXPECT_TRUE(tracer.occluded(Vector3f::Zero(), Vector3f::UnitX(), 1.5f, body_poses(scene, 2.0)));
  EXPECT_FALSE(tracer.occluded(Vector3f::Zero(), Vector3f::UnitX(), 1.5f, body_poses(scene, 0.0)));
}

}  // namespace
}  // namespace cpplus
