#include "cpplus/cloud/point_octree.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <tuple>

#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

// A wavy floor of 40 x 40 m at UTM coordinates, far more points in one corner, some of them many times at one place.
PointCloud make_floor(size_t num_points) {
  PointCloud cloud;
  cloud.origin = {600000, 5000000, 100};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> along(0.0f, 40.0f), near(0.0f, 0.5f);
  for (size_t i = 0; i < num_points; ++i) {
    std::uniform_real_distribution<float>& place = i % 2 == 0 ? along : near;
    const float x = place(random), y = place(random);
    cloud.positions.emplace_back(x, y, std::sin(x));
    if (i % 10 == 0) cloud.positions.back() = {39.0f, 1.0f, 2.0f};
  }
  return cloud;
}

// One line a node: level, key, children, points.
std::string text_of(const PointOctree& octree) {
  std::string text;
  for (const PointOctreeNode& node : octree.nodes) {
    text += fmt::format("{}:{},{},{} mask {} points", node.level, node.key.x(), node.key.y(), node.key.z(),
                        node.child_mask);
    for (uint32_t i = 0; i < node.num_points; ++i) text += fmt::format(" {}", octree.order[node.first + i]);
    text += "\n";
  }
  return text;
}

// Cell of a point at a level, along each axis.
Eigen::Vector3i cell_at(const PointOctree& octree, uint32_t point, int level) {
  Eigen::Vector3i cell;
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<int>((int64_t{octree.steps[point][axis]} << level) / octree.edge_steps);
  }
  return cell;
}

TEST(PointOctree, DividesByHand) {
  // In steps of 0.1 mm; the edge is 256, so that a cell of the root is 2 steps and its middle at 1.
  const std::vector<Eigen::Vector3i> steps = {{0, 0, 0},   {1, 1, 1},   {255, 0, 0}, {254, 0, 0},
                                              {255, 0, 0}, {0, 200, 0}, {0, 0, 129}, {255, 0, 0}};
  PointCloud cloud;
  for (const Eigen::Vector3i& x : steps) cloud.positions.push_back(x.cast<float>() * 1e-4f);
  const PointOctree octree = build_point_octree(cloud, {1});
  EXPECT_EQ(octree.corner_in_map, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(octree.step_m, 1e-4);
  EXPECT_EQ(octree.edge_steps, 256);
  EXPECT_EQ(octree.steps, steps);
  // 1 is nearer to the middle of its cell than 0, and 2 than 3; 4 and 7 lie where 2 does and come later. Below, cells
  // are a step, and what is left of one place goes into a node that cannot be divided.
  EXPECT_EQ(text_of(octree),
            "0:0,0,0 mask 17 points 1 2 5 6\n"
            "1:0,0,0 mask 0 points 0\n"
            "1:1,0,0 mask 16 points 3 4\n"
            "2:3,0,0 mask 0 points 7\n");
}

TEST(PointOctree, HoldsEveryPointOnceInItsCube) {
  const PointCloud cloud = make_floor(60000);
  const PointOctree octree = build_point_octree(cloud, {500});
  std::set<uint32_t> points;
  std::set<std::tuple<int, int, int, int>> cubes;
  int deepest = 0;
  size_t num_children = 0;
  for (const PointOctreeNode& node : octree.nodes) {
    EXPECT_GT(node.num_points, 0u);
    EXPECT_TRUE(cubes.insert({node.level, node.key.x(), node.key.y(), node.key.z()}).second);
    if (node.level > 0) {
      const Eigen::Vector3i parent = node.key / 2;
      EXPECT_EQ(cubes.count({node.level - 1, parent.x(), parent.y(), parent.z()}), 1u);
    }
    EXPECT_GE(node.level, deepest) << "level by level";
    deepest = std::max(deepest, node.level);
    num_children += static_cast<size_t>(__builtin_popcount(node.child_mask));
    for (uint32_t i = node.first; i < node.first + node.num_points; ++i) {
      EXPECT_TRUE(points.insert(octree.order[i]).second);
      EXPECT_EQ(cell_at(octree, octree.order[i], node.level), node.key);
    }
  }
  EXPECT_EQ(points.size(), cloud.size());
  EXPECT_EQ(num_children + 1, octree.nodes.size());
  EXPECT_GT(deepest, 5);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d x = octree.corner_in_map + octree.step_m * octree.steps[i].cast<double>();
    EXPECT_LT((x - cloud.point(i)).cwiseAbs().maxCoeff(), 0.5 * octree.step_m + 1e-8);
    EXPECT_GE(octree.steps[i].minCoeff(), 0);
    EXPECT_LT(octree.steps[i].maxCoeff(), octree.edge_steps);
  }
}

TEST(PointOctree, DividedNodesHoldOnePointOfEachCell) {
  const PointCloud cloud = make_floor(60000);
  const PointOctree octree = build_point_octree(cloud, {500});
  const auto key_less = [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::set<Eigen::Vector3i, decltype(key_less)> occupied(key_less), kept(key_less);
  for (uint32_t i = 0; i < cloud.size(); ++i) occupied.insert(cell_at(octree, i, 7));
  const PointOctreeNode& root = octree.nodes.front();
  for (uint32_t i = 0; i < root.num_points; ++i) kept.insert(cell_at(octree, octree.order[i], 7));
  EXPECT_EQ(kept.size(), root.num_points);
  EXPECT_TRUE(kept == occupied);
}

TEST(PointOctree, FewPointsAreOneNode) {
  PointCloud cloud;
  cloud.origin = {5, 6, 7};
  cloud.positions = {{0.25f, 0.5f, 0.75f}};
  const PointOctree octree = build_point_octree(cloud, {});
  EXPECT_EQ(text_of(octree), "0:0,0,0 mask 0 points 0\n");
  EXPECT_EQ(octree.edge_steps, point_octree_cells);
  EXPECT_NEAR(octree.corner_in_map.z(), 7.75, 1.1e-4);
}

TEST(PointOctree, ReachesAcrossFarPointsWithLongerSteps) {
  PointCloud cloud;
  cloud.positions = {{-1e6f, 0, 0}, {1e6f, 0, 0}, {1e6f, 0, 0}};
  const PointOctree octree = build_point_octree(cloud, {1});
  EXPECT_DOUBLE_EQ(octree.step_m, 1e-3);
  EXPECT_EQ(octree.steps[1].x(), 2000000000);
  EXPECT_EQ(octree.nodes.size(), 2u);
  EXPECT_EQ(octree.order[octree.nodes[1].first], 2u);
}

TEST(PointOctree, DoesNotDependOnThreads) {
  const PointCloud cloud = make_floor(60000);
  set_num_threads(1);
  const PointOctree one = build_point_octree(cloud, {500});
  set_num_threads(4);
  const PointOctree four = build_point_octree(cloud, {500});
  set_num_threads(0);
  EXPECT_EQ(one.steps, four.steps);
  EXPECT_EQ(text_of(one), text_of(four));
}

}  // namespace
}  // namespace cpplus
