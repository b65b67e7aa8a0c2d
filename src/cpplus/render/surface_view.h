#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct SurfaceViewOptions {
  /// Points farther than this from the camera centre are not drawn, metres. (0, inf)
  double max_distance_m = 60.0;
  /// Radius of the disc that a point covers, in distances to its neighbours. (0, 10]
  double disc_spacings = 1.5;
  /// Surfaces that lie this close behind each other, measured across them, are averaged: it should exceed the thickness
  /// of a wall in the map. Metres, (0, inf)
  double thickness_m = 0.06;
  /// A pixel whose discs lie too much on one side of it, by this share of their radius, is beyond the end of the
  /// surface and stays empty. (0, 1]
  double max_lopsidedness = 0.45;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_distance_m", max_distance_m, "Points farther than this from the camera are not drawn, metres.");
    visitor("disc_spacings", disc_spacings, "Radius of the disc of a point, in distances to its neighbours. (0, 10]");
    visitor("thickness_m", thickness_m, "Surfaces this close behind each other are averaged, metres.");
    visitor("max_lopsidedness", max_lopsidedness,
            "Pixels whose discs lie on one side by this share of their radius stay empty. (0, 1]");
  }
};

/// What a map is drawn from: its points as small discs.
struct MapDiscs {
  /// One a point, in map order: unit normal in the map frame, either sign; zero where it is not known.
  std::vector<Eigen::Vector3f> normals;
  /// One a leaf: distance between neighbouring points, metres; infinite where there is no surface.
  std::vector<float> leaf_spacing_m;
};

/// The nearest surface of the map at each pixel.
struct SurfaceView {
  RangeImage range;                // metres along the ray of the pixel's centre; 0 = nothing there
  Image<Eigen::Vector3f> normals;  // unit, camera frame, towards the camera; zero = nothing there, or not known
};

/// The rays of the centres of all pixels of a camera (unit, camera frame; zero where the model gives none). Made once a
/// camera, used for all its images.
Image<Eigen::Vector3f> pixel_bearings(const Camera& camera);

/// Draws a map in two passes: first the nearest disc at each pixel, then the mean of the discs that lie no more than
/// thickness_m behind it, weighted by 1 - (d / radius)^2 with d the distance between the point and where the ray meets
/// the plane of its disc. (Discs without a normal face the camera.) Averaging takes away most of the noise, which the
/// nearest disc alone would turn into a bias towards the camera.
///
/// Time is linear in the points in view and the pixels they cover. The result does not depend on the number of threads.
SurfaceView render_surface(const VoxelMap& map, const MapDiscs& discs, const Camera& camera,
                           const Image<Eigen::Vector3f>& bearings, const Rigid3& camera_from_map,
                           const SurfaceViewOptions& options);

}  // namespace cpplus
