#pragma once

#include <vector>

#include "cpplus/cloud/intensity_match.h"
#include "cpplus/core/image.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct IntensityMatchingOptions {
  /// Off: LiDAR intensities tell where they change along an edge alone.
  bool enabled = true;
  /// Edge of a patch; patches overlap by half, pixels. [16, inf)
  int patch_px = 72;
  /// A patch is looked for this far from where the pose puts it, pixels. [2, inf)
  int search_radius_px = 10;
  /// Gaussian blur of the image, about as wide as the LiDAR's beams are, pixels. (0, inf)
  double blur_sigma_px = 2.0;
  /// Fewest points of a patch. [16, inf)
  int min_points = 120;
  /// Of more points of a patch an even choice is taken. [16, inf)
  int max_points = 400;
  /// Least correlation of intensity and brightness, of either sign. (0, 1)
  double min_correlation = 0.6;
  /// So many points together tell as much as an independent one: neighbours see the same, and brightness is not
  /// reflectance. [1, inf)
  double points_per_measurement = 10.0;
  /// Standard deviations that no number of points makes smaller: in the image, pixels, and of the map, metres.
  /// [0, inf)
  double pixel_sigma_px = 0.3;
  double map_sigma_m = 0.004;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("enabled", enabled, "Match patterns of LiDAR intensity with the image's brightness.");
    visitor("patch_px", patch_px, "Edge of a patch of the image, pixels.");
    visitor("search_radius_px", search_radius_px, "How far from its expected place a patch is looked for, pixels.");
    visitor("blur_sigma_px", blur_sigma_px, "Gaussian blur of the image, pixels.");
    visitor("min_points", min_points, "Fewest points of a patch.");
    visitor("max_points", max_points, "Of more points of a patch an even choice is taken.");
    visitor("min_correlation", min_correlation, "Least correlation of intensity and brightness.");
    visitor("points_per_measurement", points_per_measurement, "So many points tell as much as an independent one.");
    visitor("pixel_sigma_px", pixel_sigma_px, "Least standard deviation of a patch's place in the image, pixels.");
    visitor("map_sigma_m", map_sigma_m, "Least standard deviation of a patch's place in the map, metres.");
  }
};

/// What is known of the view before its intensities are looked at.
struct ExpectedView {
  const Camera& camera;
  Rigid3 camera_from_map;
  Matrix6d covariance;  // of the perturbation (geometry/rigid3.h)
};

/// Finds patches of an image in which the intensities of the map's points and the brightness of the pixels that they
/// fall on go together, once all points of the patch are shifted alike by d. With rho(d) the correlation, what is
/// linear over the patch removed from both, n points and k = points_per_measurement, the shift's log-likelihood is
///
///   L(d) = -n/(2k) log(1 - rho(d)^2)
///
/// (a Gaussian brightness that is linear in the intensity, gain and offset unknown). The match is a peak of L, the one
/// that is likeliest under a wide prior around 0; its information is the curvature of L there, limited by the two least
/// standard deviations, its weight a quarter, since each point is in four patches. Patches whose place the pose does
/// not know to half the search radius (one standard deviation) are left out: a peak within reach might not be theirs.
/// So are peaks at the border of what was looked at, and ridges without a peak.
///
/// `points`: those that the image shows at the pose of `view`, in any order that does not depend on chance. Matches
/// are in the order of the patches, row by row.
std::vector<IntensityMatch> match_intensities(const std::vector<IntensityPoint>& points, const GrayImage& image,
                                              const ExpectedView& view, const IntensityMatchingOptions& options);

}  // namespace cpplus
