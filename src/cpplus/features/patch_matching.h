#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cpplus/cloud/plane_buffer.h"
#include "cpplus/cloud/range_raster.h"
#include "cpplus/cloud/surface_match.h"
#include "cpplus/core/image.h"
#include "cpplus/core/options.h"
#include "cpplus/features/patch_surface.h"

namespace cpplus {

struct PatchMatchingOptions {
  /// Off: images are tied together by what they share alone.
  bool enabled = true;
  /// Most patches of an image that are looked for in another one. [1, inf)
  int max_patches = 200;
  /// Least distance between patches, pixels. (0, inf)
  double min_distance_px = 16.0;
  /// Half the edge of a patch, pixels of each pyramid level. [2, inf)
  int radius_px = 5;
  /// A patch is looked for this far from where the poses put it, pixels of the full image. (0, inf)
  double search_radius_px = 48.0;
  /// Least normalised cross-correlation at full resolution. (0, 1)
  double min_correlation = 0.85;
  /// By how much the best place must correlate better than any other within the search radius. [0, 1)
  double min_distinction = 0.05;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("enabled", enabled, "Look for patches of the map's surface in other images.");
    visitor("max_patches", max_patches, "Most patches of an image that are looked for in another one.");
    visitor("min_distance_px", min_distance_px, "Least distance between patches, pixels.");
    visitor("radius_px", radius_px, "Half the edge of a patch, pixels of each pyramid level.");
    visitor("search_radius_px", search_radius_px, "How far from its expected place a patch is looked for, pixels.");
    visitor("min_correlation", min_correlation, "Least normalised cross-correlation of a match.");
    visitor("min_distinction", min_distinction, "By how much the best place must correlate better than any other.");
  }
};

/// An image made ready for patch matching; of many images at a time, so only what that looks at.
struct PatchView {
  /// A corner on a flat piece of the map's surface.
  struct Patch {
    Eigen::Vector2d pixel;
    PatchSurface surface;
  };

  GrayImage image;
  std::vector<Image<float>> halves;  // of half the size each
  PlaneBuffer planes;                // with camera and pose
  RangeRaster raster;                // from the same pose, the ranges alone
  std::vector<Patch> patches;
};

/// Finds the corners of an image that lie on flat pieces of the map's surface (patch_surface.h) as seen from the pose
/// of the plane buffer, which is that of the raster.
PatchView prepare_patch_view(const GrayImage& image, const PlaneBuffer& planes, const RangeRaster& raster,
                             const PatchMatchingOptions& options);

/// Finds the patches of view a in view b. The poses and the surface of the map say how a patch is seen from b, up to a
/// shift: its affinely warped copy is looked for by normalised cross-correlation from the coarsest level to the full
/// image, then placed to a fraction of a pixel by Gauss-Newton on brightness, gain and offset removed (Lucas and Kanade
/// 1981). Works on the recorded, distorted images of any camera model. image_a and image_b of the matches are 0.
std::vector<SurfaceMatch> match_patches(const PatchView& a, const PatchView& b, const PatchMatchingOptions& options);

/// Share of view a's patches that view b should see, by the poses alone.
double patch_overlap(const PatchView& a, const PatchView& b);

}  // namespace cpplus
