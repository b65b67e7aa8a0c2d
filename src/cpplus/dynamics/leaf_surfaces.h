#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/cloud/voxel_map.h"

namespace cpplus {

/// What the leaves of the map of all scans know of the surface in them. By leaf.
struct LeafSurfaces {
  std::vector<uint32_t> num_scans;       // how many scans hit the leaf: the size of its set of scan identifiers
  std::vector<Eigen::Vector3f> means;    // of the points, relative to the map's origin, metres
  std::vector<Eigen::Vector3f> normals;  // unit normal of the plane that the leaf lies on, zero where there is none
};

/// `map` is the voxel map of scans.points. A leaf takes the normal of the smallest voxel of the two layers 2 and 3
/// above it whose points are a plane and that its own mean lies on.
LeafSurfaces measure_leaf_surfaces(const VoxelMap& map, const ScanSet& scans);

struct SurfacePatch {
  Eigen::Vector3f mean;    // in the frame of the points
  Eigen::Vector3f normal;  // unit
};
/// The plane through some points, where they are one: more than a line, and thin.
std::optional<SurfacePatch> fit_patch(const std::vector<Eigen::Vector3f>& points);

}  // namespace cpplus
