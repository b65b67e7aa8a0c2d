#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/point_cloud.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/random.h"

namespace cpplus {

/// Adds `density` points a square metre, spread at random over corner + s u + t v with s and t in [0, 1], with noise
/// along the normal. All of one intensity.
inline void add_surface(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                        double density, double noise_m, Random* random, PointCloud* cloud, float intensity = 100.0f) {
  const Eigen::Vector3d cross = u.cross(v);
  const int count = static_cast<int>(density * cross.norm());
  for (int i = 0; i < count; ++i) {
    const double s = random->uniform();
    const double t = random->uniform();
    const double noise = noise_m > 0.0 ? noise_m * random->normal() : 0.0;
    cloud->positions.push_back((corner + s * u + t * v + noise * cross.normalized()).cast<float>());
    cloud->intensities.push_back(intensity);
  }
}

/// Turns all points about an oblique axis and moves them, so that nothing is aligned with the voxels.
inline Eigen::Isometry3d oblique_frame() {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.translate(Eigen::Vector3d(0.313, -0.171, 0.077));
  frame.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, -0.5, 1.0).normalized()));
  return frame;
}

inline void transform(const Eigen::Isometry3d& frame, PointCloud* cloud) {
  for (Eigen::Vector3f& x : cloud->positions) x = (frame * x.cast<double>()).cast<float>();
}

}  // namespace cpplus
