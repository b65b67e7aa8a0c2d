#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// Which plane instance of the map is nearest in each direction that a camera looks in, on cells of the recorded image.
/// Only planes of some size are in it, so what moved through the scan (people, cars) hides nothing; and the range
/// of a plane along a ray is exact, also where the points are sparse or the view is grazing.
struct PlaneBuffer {
  static constexpr int32_t kNone = -1;

  Camera camera;
  Rigid3 camera_from_map;
  double cell_px = 4.0;
  Image<int32_t> plane;  // per cell: index of the plane instance, or kNone
  /// Per cell: what the range of its plane does not exceed there, metres; the largest float without a plane. Empty
  /// where nothing is known.
  RangeImage range_bound;
  const std::vector<MapPlane>* planes = nullptr;

  /// Plane at an image pixel; kNone outside the image.
  int32_t plane_at(const Eigen::Vector2d& pixel) const;

  /// Whether a point at this pixel is nowhere hidden by more than margin_m in the 3x3 cells around it: at least one of
  /// them shows no plane that has the camera on one side and the point more than margin_m beyond it.
  bool is_visible(const Eigen::Vector3d& x_in_map, const Eigen::Vector2d& pixel, double margin_m) const;

  /// Range along a bearing (unit, camera frame) at which the given plane is met, metres; NaN where it is not.
  double range_along(const MapPlane& plane_instance, const Eigen::Vector3d& bearing) const;
  /// The same along the bearing of `pixel`.
  double range_of(const MapPlane& plane_instance, const Eigen::Vector2d& pixel) const;
};

}  // namespace cpplus
