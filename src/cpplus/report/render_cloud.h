#pragma once

#include <Eigen/Core>

#include "cpplus/cloud/depth_buffer.h"
#include "cpplus/cloud/point_cloud.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct CloudRendering {
  ColorImage picture;
  Image<uint8_t> colored;  // 1 where the point in front has the colour of an image (num_views > 0)
};

/// A picture of the coloured cloud as the camera of `surface` sees it. Each point is a square of point_size_m at its
/// distance (between 1 and 15 pixels); a pixel takes the mean of the points of the nearest surface there, weighted by a
/// bell around each of them (Zwicker et al. 2001, without its filter for minification). What lies behind `surface` is
/// not drawn, so that it does not shine through the gaps between the points in front; where `surface` has no range, all
/// is. Pixels that no point covers are dark blue. The cloud must have colours; points that no image gave a colour to
/// (num_views 0) are drawn as they are, but not `colored`; a cloud without view counts is colored wherever it is drawn.
/// Linear in the points.
CloudRendering render_colored_cloud(const PointCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map,
                                    double point_size_m);

/// Whether a point (camera frame of `surface`, metres) is drawn there: in the picture or just outside of it, and not
/// behind the surface. A cloud without its other points gives the same picture.
bool is_drawn(const Eigen::Vector3d& x_in_camera, const DepthBuffer& surface);

/// Only the picture.
ColorImage render_cloud(const PointCloud& cloud, const DepthBuffer& surface, const Rigid3& camera_from_map,
                        double point_size_m);

/// Two pictures of the same height, one beside the other.
ColorImage side_by_side(const ColorImage& left, const ColorImage& right);

}  // namespace cpplus
