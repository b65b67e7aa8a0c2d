#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "cpplus/cloud/point_cloud.h"
#include "cpplus/core/random.h"

namespace cpplus {

/// Adds the rectangle corner + s u + t v, s and t in [0, 1], as points about `spacing` metres apart, with noise along
/// its normal.
inline void add_rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                          double spacing, double noise_m, Random* random, PointCloud* cloud) {
  const Eigen::Vector3d normal = u.cross(v).normalized();
  const int num_u = static_cast<int>(u.norm() / spacing);
  const int num_v = static_cast<int>(v.norm() / spacing);
  for (int i = 0; i <= num_u; ++i) {
    for (int j = 0; j <= num_v; ++j) {
      const double s = (i + random->uniform(-0.3, 0.3)) / num_u;
      const double t = (j + random->uniform(-0.3, 0.3)) / num_v;
      const Eigen::Vector3d x = corner + s * u + t * v + noise_m * random->normal() * normal;
      cloud->positions.push_back(x.cast<float>());
    }
  }
}

}  // namespace cpplus
