#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Mean distance, pixels, by which points of the map move in the image when the camera goes from one pose to another,
/// over those that both poses project; 0 where there are none.
double mean_displacement_px(const Camera& camera, const std::vector<Eigen::Vector3d>& points_in_map,
                            const Rigid3& from_camera_from_map, const Rigid3& to_camera_from_map);

}  // namespace cpplus
