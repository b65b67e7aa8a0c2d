#pragma once

#include <Eigen/Core>
#include <cmath>

#include "cpplus/refine/edge_match.h"

namespace cpplus {

/// Sets sigma_px and weight of a match by the noise models of the LiDAR (through the edge's covariance, square metres)
/// and of the camera (Yuan et al. 2021, section IV). What the samples of an edge have in common does not average out
/// over them: with m samples of variance a and a common variance c, all together know the edge to a/m + c, which a
/// variance of a + m c a sample reproduces. The edge's direction is as uncertain as its ends are when they are as
/// uncertain as the edge.
inline void weigh_match(const Eigen::Matrix3d& edge_covariance, double edge_length_m, const EdgeSample& sample,
                        double image_sigma_px, double edge_sigma_px, EdgeMatch* m) {
  const Eigen::RowVector3d d_residual_d_point = m->normal.transpose() * m->projected.d_pixel_d_point;
  const double map_variance = (d_residual_d_point * edge_covariance * d_residual_d_point.transpose()).value();
  const double own = image_sigma_px * image_sigma_px;
  const double common = map_variance + edge_sigma_px * edge_sigma_px;
  m->sigma_px = std::sqrt(own + common);
  m->weight = (own + common) / (own + sample.edge_samples * common);
  m->slip_in_map = std::sqrt(map_variance) / (0.5 * edge_length_m) * sample.direction_in_map;
}

}  // namespace cpplus
