#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/io/deep_image_io.h"
#include "cpplus/render/surface_view.h"

namespace cpplus {

/// Depth of each pixel of a view, metres; 0 = nothing there. "z": along the optical axis (0 where it is not positive),
/// "range": along the ray of the pixel.
Image<float> depth_of(const SurfaceView& view, const Image<Eigen::Vector3f>& bearings, const std::string& kind);

/// Depth in whole millimetres; 0 = nothing there, or more than 65.535 m.
DeepImage depth_in_mm(const Image<float>& depth_m);

/// Normals (camera frame) as red, green, blue: 65535 * (n + 1) / 2, rounded; 0 0 0 = none.
DeepColorImage normals_in_16_bits(const Image<Eigen::Vector3f>& normals);

/// Draws a map into one view after the other.
class SurfaceRenderer {
 public:
  /// The map must outlive it.
  SurfaceRenderer(const VoxelMap& map, const SurfaceViewOptions& options);

  /// Rays of a camera's pixels, made once an id.
  const Image<Eigen::Vector3f>& bearings(uint32_t camera_id, const Camera& camera);
  SurfaceView render(uint32_t camera_id, const Camera& camera, const Rigid3& camera_from_map);

 private:
  const VoxelMap& map_;
  SurfaceViewOptions options_;
  MapDiscs discs_;
  std::map<uint32_t, Image<Eigen::Vector3f>> bearings_;
};

}  // namespace cpplus
