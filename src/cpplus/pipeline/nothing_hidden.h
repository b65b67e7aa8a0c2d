#pragma once

#include <algorithm>
#include <vector>

#include "cpplus/cloud/plane_buffer.h"

namespace cpplus {

/// The plane buffer of a view in which nothing hides anything: one cell without a plane covers the image, since what
/// lies outside a buffer counts as hidden. `planes` must outlive it.
inline PlaneBuffer nothing_hidden(const std::vector<MapPlane>& planes, const Camera& camera,
                                  const Rigid3& camera_from_map) {
  PlaneBuffer buffer;
  buffer.camera = camera;
  buffer.camera_from_map = camera_from_map;
  buffer.cell_px = std::max(camera.width(), camera.height());
  buffer.plane = Image<int32_t>(1, 1, PlaneBuffer::kNone);
  buffer.planes = &planes;
  return buffer;
}

}  // namespace cpplus
