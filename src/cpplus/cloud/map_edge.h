#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

namespace cpplus {

enum class MapEdgeKind {
  kCrease,      // two planes meet: depth-continuous
  kBoundary,    // a plane ends: depth-discontinuous where something farther is seen beyond it
  kIntensity,   // the LiDAR intensity changes on a plane
  kSilhouette,  // the near surface ends, as one view sees it: depth-discontinuous
};

/// A straight edge of the map.
struct MapEdge {
  MapEdgeKind kind = MapEdgeKind::kCrease;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // map frame, metres
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  /// Unit normals of the planes it lies on; only the first for edges of one plane.
  Eigen::Vector3d normal_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_b = Eigen::Vector3d::Zero();
  /// Unit directions in each plane, perpendicular to the edge, towards its surface.
  Eigen::Vector3d inward_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d inward_b = Eigen::Vector3d::Zero();
  /// Covariance of the position of its points, square metres; nothing along the edge.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Pieces of one long edge share this number: their errors are not independent.
  uint32_t group = 0;

  double length() const { return (end - start).norm(); }
  Eigen::Vector3d direction() const { return (end - start).normalized(); }
};

/// The least number that is no group's and larger than all of them.
inline uint32_t first_free_group(const std::vector<MapEdge>& edges) {
  uint32_t free = 0;
  for (const MapEdge& edge : edges) free = std::max(free, edge.group + 1);
  return free;
}

/// Adds edges whose groups are numbered on their own: numbers them from first_group on.
inline void append_groups(const std::vector<MapEdge>& part, uint32_t first_group, std::vector<MapEdge>* edges) {
  for (const MapEdge& edge : part) {
    edges->push_back(edge);
    edges->back().group += first_group;
  }
}

/// One list of edges whose groups are numbered within each part: renumbers them so that they stay apart.
inline std::vector<MapEdge> concatenate_groups(const std::vector<std::vector<MapEdge>>& parts) {
  std::vector<MapEdge> edges;
  uint32_t first_group = 0;
  for (const std::vector<MapEdge>& part : parts) {
    append_groups(part, first_group, &edges);
    first_group += first_free_group(part);
  }
  return edges;
}

}  // namespace cpplus
