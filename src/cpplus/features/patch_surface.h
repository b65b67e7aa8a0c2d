#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "cpplus/cloud/map_plane.h"
#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/range_raster.h"

namespace cpplus {

/// The map's surface under a patch of an image, flat.
struct PatchSurface {
  int32_t plane_id = PlaneBuffer::kNone;  // plane instance of the map; kNone where it is none
  MapPlane plane;                         // that, or the tangent plane of the points in view; map frame
  double range_sigma_m = 0.0;             // of the surface along the ray of the patch's middle
};

/// The one plane instance under the square of half edge radius_px around a pixel if there is one, the raster shows
/// nothing in front of it and its points lie on it within centimetres: in its direction, where these points have it;
/// else the tangent plane through the raster's points there, of ranges r by least squares in 1 / r = n . bearing, which
/// is linear for every camera model. Nothing where a fifth of the cells show something else, their means lie off that
/// plane by more than a few centimetres, or less than most of them show a surface.
std::optional<PatchSurface> surface_under(const PlaneBuffer& planes, const RangeRaster& raster,
                                          const Eigen::Vector2d& pixel, double radius_px);

/// Whether the raster shows no surface in front of a point at this pixel.
bool is_seen(const RangeRaster& raster, const Eigen::Vector2d& pixel, double range_m);

}  // namespace cpplus
