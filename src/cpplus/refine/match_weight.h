#pragma once

#include <Eigen/Core>
#include <cmath>

#include "cpplus/refine/edge_match.h"

namespace cpplus {

/// Sets sigma_px and weight of a match by the noise models of the LiDAR (through the edge's covariance, square metres)
/// and of the camera (Yuan et al. 2021, section IV). What the samples of an edge have in common does not average out
/// over them: with m samples of variance a and a common variance c, all together know the edge to a/m + c, which a
/// variance of a + m c a sample reproduces.
inline void weigh_match(const Eigen::Matrix3d& edge_covariance, int edge_samples, double image_sigma_px,
                        double edge_sigma_px, EdgeMatch* m) {
  const Eigen::RowVector3d d_residual_d_point = m->normal.transpose() * m->projected.d_pixel_d_point;
  const double map_variance = (d_residual_d_point * edge_covariance * d_residual_d_point.transpose()).value();
  const double own = image_sigma_px * image_sigma_px;
  const double common = map_variance + edge_sigma_px * edge_sigma_px;
  m->sigma_px = std::sqrt(own + common);
  m->weight = (own + common) / (own + edge_samples * common);
}

}  // namespace cpplus
