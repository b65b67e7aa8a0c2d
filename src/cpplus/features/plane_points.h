#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// The points of one plane instance in coordinates of the plane.
struct PlanePoints {
  Eigen::Vector3d origin;  // map frame, metres
  Eigen::Vector3d axis_u;  // unit, in the plane
  Eigen::Vector3d axis_v;
  Eigen::Vector3d normal;
  std::vector<Eigen::Vector2d> positions;  // metres
  std::vector<uint32_t> indices;           // map order

  Eigen::Vector3d in_map(const Eigen::Vector2d& position) const {
    return origin + position.x() * axis_u + position.y() * axis_v;
  }
  Eigen::Vector3d direction_in_map(const Eigen::Vector2d& direction) const {
    return direction.x() * axis_u + direction.y() * axis_v;
  }
};

PlanePoints plane_points(const VoxelMap& map, const PlaneSegmentation& planes, size_t plane);

/// One point a cell of cell_m: the index in `points.positions` of the one nearest to the mean of its cell. Evens out
/// the dense scan lines of a LiDAR, whose neighbours are otherwise all on the same line.
std::vector<uint32_t> thin_points(const PlanePoints& points, double cell_m);

}  // namespace cpplus
