#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// A point of the map as a camera sees it.
struct ProjectedPoint {
  Eigen::Vector2f pixel;
  float range = 0.0f;       // metres
  float spacing_px = 0.0f;  // between it and its neighbours on the surface
};

/// Takes some points, and their places in the order of the map.
using VisitProjectedPoints =
    std::function<void(std::span<const ProjectedPoint> points, std::span<const uint32_t> indices)>;

/// Hands over the points within max_distance_m that project into the image of the plane buffer and belong to a surface
/// (finite spacing), without most of those that its planes hide clearly (hidden_ranges.h), in the order of the map, in
/// runs while the processor's cache holds them. leaf_spacing as leaf_point_spacing() gives it.
void project_points(const VoxelMap& map, const std::vector<float>& leaf_spacing, const PlaneBuffer& planes,
                    double max_distance_m, const VisitProjectedPoints& visit);

}  // namespace cpplus
