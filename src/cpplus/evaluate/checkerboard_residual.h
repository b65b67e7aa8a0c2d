#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A checkerboard whose inner corners are known in the map and were found in some images.
struct Checkerboard {
  std::string name;
  std::vector<Eigen::Vector3d> corners_in_map;  // metres
  struct Sighting {
    std::string image_name;
    std::vector<Eigen::Vector2d> corner_pixels;  // one for each of corners_in_map, in the same order
  };
  std::vector<Sighting> sightings;
};

/// The paper's residual of one image (Eq. 6, CP+): the mean distance in pixels between the corners found in the image
/// and the projections of the corners of the map, over all boards sighted in it. A corner that the pose does not
/// project counts with the image diagonal, and no corner with more. NaN where no board is sighted.
/// Throws Error where a sighting has another number of corners than its board.
double checkerboard_residual_px(const std::vector<Checkerboard>& boards, const std::string& image_name,
                                const Camera& camera, const Rigid3& camera_from_map);

}  // namespace cpplus
