#pragma once

#include "cpplus/geometry/camera.h"

namespace cpplus {

/// The camera of images that were resized by the factor: size, focal lengths and principal point. Resizing keeps the
/// borders of the image in place, not the centres of its pixels.
Camera scaled_camera(const Camera& camera, double scale);

}  // namespace cpplus
