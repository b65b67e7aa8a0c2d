#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/point_cloud.h"

namespace cpplus {

struct PointOctreeOptions {
  /// A node with more points in its cube is divided.
  size_t max_points = 10000;
};

/// A node that is divided keeps one point for each of so many cells along each edge of its cube.
constexpr int point_octree_cells = 128;

/// A cube of the octree, with the points that are shown when it is: those of its parents stay.
struct PointOctreeNode {
  int level = 0;                                  // 0 = the whole cube, 1 = its octants, ...
  Eigen::Vector3i key = Eigen::Vector3i::Zero();  // place of the cube among those of its level
  uint32_t first = 0;                             // of its points, a place in PointOctree::order
  uint32_t num_points = 0;
  uint8_t child_mask = 0;  // bit 4 x + 2 y + z for a child in the upper (1) or lower (0) half along each axis
};

/// A cloud in levels of detail: each point is in exactly one node. Positions are whole steps, which decide on the node,
/// so that they lie in its cube exactly: along each axis floor(steps * 2^level / edge_steps) = key.
struct PointOctree {
  Eigen::Vector3d corner_in_map = Eigen::Vector3d::Zero();  // the least of the cube's corners, metres
  double step_m = 0.0;
  int32_t edge_steps = 0;              // edge of the cube
  std::vector<Eigen::Vector3i> steps;  // position of each point of the cloud: corner_in_map + step_m * steps
  std::vector<uint32_t> order;         // places in the cloud; a node's points, then those of all nodes below it
  std::vector<PointOctreeNode> nodes;  // level by level, children of one node together, ascending in the octant

  double edge_m() const { return step_m * edge_steps; }
};

/// Divides the cube from above: a node with more than max_points keeps, of each cell with points, the one nearest to
/// the cell's middle (the first of several), and hands the others to its octants; a node of fewer points, or whose
/// cells would be smaller than a step, keeps all. Steps are 0.1 mm, or the next power of ten at which 31 bits reach
/// across the cloud. Points must be finite. Takes time linear in points and levels, and 24 bytes a point, of which 16
/// stay, and 16 MB a thread. Throws Error for more than 2^32 - 2 points.
PointOctree build_point_octree(const PointCloud& cloud, const PointOctreeOptions& options);

}  // namespace cpplus
