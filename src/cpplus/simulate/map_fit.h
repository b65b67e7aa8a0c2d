#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// One map point: where it is in truth, and where the map has it.
struct DisplacedPoint {
  Eigen::Vector3d x_in_truth;
  Eigen::Vector3d x_in_map;
};

/// The camera_from_map whose projections of the map's points come closest (least squares, pixels) to the projections
/// of the true points from the true pose: the best that any refinement against this map can find. Returns the true
/// pose where fewer than 30 points project.
Rigid3 fit_pose_to_map(const Camera& camera, const Rigid3& true_camera_from_map,
                       const std::vector<DisplacedPoint>& points);

}  // namespace cpplus
