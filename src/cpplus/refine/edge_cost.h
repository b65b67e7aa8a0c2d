#pragma once

#include <Eigen/Core>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_samples.h"

namespace ceres {
class CostFunction;
}

namespace cpplus {

/// Residual of one matched sample, Eq. 5 of Cui & Schwertfeger 2022: the distance along the image edge's unit normal
/// between the projected sample and the edgel, in standard deviations; the parameter is the perturbation (6) of
/// base_camera_from_map as in geometry/rigid3.h. A sample that leaves the camera model's range has residual 0.
ceres::CostFunction* make_edge_cost(const Camera& camera, const Rigid3& base_camera_from_map,
                                    const Eigen::Vector3d& x_in_map, const Eigen::Vector2d& edgel_pixel,
                                    const Eigen::Vector2d& edgel_normal, double sigma_px);

/// Residuals (6) of the prior: perturbation of base_camera_from_map minus that of the coarse pose, in standard
/// deviations.
ceres::CostFunction* make_prior_cost(const Vector6d& mean, const Vector6d& sigmas);

}  // namespace cpplus
