#include "cpplus/simulate/true_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// A box of 1 x 0.6 x 0.4 m on a floor of 4 x 4 m.
Scene box_on_floor() {
  Scene scene;
  scene.materials.resize(1);
  scene.objects = {"floor", "box"};
  MeshBuilder builder(&scene.mesh);
  builder.add_box({-2.0, -2.0, -0.2}, {2.0, 2.0, 0.0}, 0);
  builder.set_object(1);
  builder.add_box({-0.5, -0.3, 0.0}, {0.5, 0.3, 0.4}, 0);
  return scene;
}

TEST(TrueEdges, BoxOnAFloorByHand) {
  const Scene scene = box_on_floor();
  const Tracer tracer(scene);
  const auto edges = find_true_edges(tracer);
  // Floor slab: 12 convex. Box: 4 upright and 4 upper ones convex, 4 contact lines concave; its lower borders are
  // those contact lines, not convex edges.
  ASSERT_EQ(edges.size(), 24u);
  EXPECT_EQ(std::count_if(edges.begin(), edges.end(), [](const TrueEdge& e) { return e.convex; }), 20);
  for (const TrueEdge& edge : edges) {
    if (edge.convex) continue;
    EXPECT_NEAR(edge.begin.z(), 0.0, 1e-6);
    EXPECT_NEAR(edge.end.z(), 0.0, 1e-6);
    const bool along_x = std::abs(edge.begin.x() - edge.end.x()) > 0.1;
    EXPECT_NEAR((edge.end - edge.begin).norm(), along_x ? 1.0 : 0.6, 2e-3);
    EXPECT_NEAR(std::abs(along_x ? edge.begin.y() : edge.begin.x()), along_x ? 0.3 : 0.5, 1e-6);
    EXPECT_NEAR(edge.normal_a.dot(edge.normal_b), 0.0, 1e-6);
  }
}

TEST(TrueEdges, ABoxSunkIntoTheFloorMeetsItWhereItPassesThrough) {
  Scene scene = box_on_floor();
  MeshBuilder builder(&scene.mesh);
  builder.add_box({1.0, 1.0, -0.1}, {1.5, 1.5, 0.3}, 0);
  const Tracer tracer(scene);
  const auto edges = find_true_edges(tracer);
  EXPECT_EQ(edges.size(), 24u + 12u);
}

TEST(TrueEdges, WhatAnotherThingCoversIsNoEdge) {
  Scene scene = box_on_floor();
  const size_t before = find_true_edges(Tracer(scene)).size();
  // A larger box swallows the first one.
  MeshBuilder(&scene.mesh).add_box({-0.7, -0.5, 0.0}, {0.7, 0.5, 0.6}, 0);
  EXPECT_EQ(find_true_edges(Tracer(scene)).size(), before);
}

TEST(TrueEdges, PiecesOfOneWallMakeOneEdge) {
  Scene scene;
  scene.materials.resize(1);
  scene.objects = {"wall"};
  MeshBuilder builder(&scene.mesh);
  builder.add_box({0.0, 0.0, 0.0}, {1.0, 0.2, 1.0}, 0);
  builder.add_box({1.0, 0.0, 0.0}, {2.5, 0.2, 1.0}, 0);
  const auto edges = find_true_edges(Tracer(scene));
  EXPECT_EQ(edges.size(), 12u);
  const auto longest = std::max_element(edges.begin(), edges.end(), [](const TrueEdge& a, const TrueEdge& b) {
    return (a.end - a.begin).norm() < (b.end - b.begin).norm();
  });
  EXPECT_NEAR((longest->end - longest->begin).norm(), 2.5, 3e-3);
}

}  // namespace
}  // namespace cpplus
