#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cpplus {

/// A plane instance of the map: one flat surface, seen from one side, of any extent.
struct MapPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // unit, map frame
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  // map frame, metres
  double sigma_m = 0.0;                                // RMS distance of its points
  uint32_t num_points = 0;

  double signed_distance(const Eigen::Vector3d& x_in_map) const { return normal.dot(x_in_map - centroid); }
};

/// All plane instances of a map and the points that belong to them.
struct PlaneSegmentation {
  static constexpr int32_t kNone = -1;

  std::vector<MapPlane> planes;
  double noise_m = 0.0;                       // range noise of the map, standard deviation
  std::vector<int32_t> plane_of_point;        // per map-order point; kNone where it lies on no plane
  std::vector<std::vector<uint32_t>> leaves;  // per plane: the leaves that hold its points, ascending
};

}  // namespace cpplus
