#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "cpplus/geometry/camera.h"

namespace cpplus {

struct PinholeViewOptions {
  /// Largest angle of view across and down, degrees: a fisheye image is cut off there. (0, 170]
  double max_fov_deg = 100.0;
  /// Puts the principal point into the middle of the image, for programs that take it to be there.
  bool centered = false;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_fov_deg", max_fov_deg, "Largest angle of view across and down of an undistorted image. (0, 170]");
  }
};

/// A PINHOLE camera at the centre of another one:   x_in_view = view_from_camera * x_in_camera.
struct PinholeView {
  Camera camera;
  Eigen::Quaterniond view_from_camera = Eigen::Quaterniond::Identity();
  std::string suffix;  // for names: "" for an only view, "_front" ... for the faces of a panorama
};

/// The pinhole cameras that show what a camera sees, without a pixel from outside its image and about as many pixels
/// per radian in the middle.
///
/// - A camera with an image plane or a fisheye gives one view that looks the same way: its centre is the old principal
///   point, its focal lengths are the old ones, and its borders are the largest for which every pixel lies in the
///   recorded image and within max_fov_deg. Not centred, a PINHOLE or SIMPLE_PINHOLE camera stays as it is.
/// - EQUIRECTANGULAR gives the six faces of a cube: front, right, back, left, up, down, 90 degrees each.
///
/// Throws Error where no view of at least 8 x 8 pixels is possible.
std::vector<PinholeView> pinhole_views(const Camera& camera, const PinholeViewOptions& options);

}  // namespace cpplus
