#pragma once

#include <Eigen/Geometry>

#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"

namespace cpplus {

/// Where each pixel of a view lies in the image of another camera at the same place (pixels; both -1e6 where that
/// camera shows nothing):   x_in_view = view_from_camera * x_in_camera. Made once a camera, used for all its images.
struct ResampleTable {
  Image<float> x;
  Image<float> y;
};

ResampleTable make_resample_table(const Camera& camera, const Camera& view, const Eigen::Quaterniond& view_from_camera);

/// The image as the view shows it, bilinear, black where there is nothing. `wraps`: the columns of the image go all the
/// way round (EQUIRECTANGULAR).
ColorImage resample_image(const ColorImage& image, const ResampleTable& table, bool wraps);

}  // namespace cpplus
