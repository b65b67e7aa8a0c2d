#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/depth_buffer.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// An image to take colours from.
struct ColorView {
  std::string name;        // for error messages
  uint16_t index = 0;      // of the image among all that give colours
  uint32_t image_id = 0;   // of the model; becomes PointCloud::best_images
  uint32_t camera_id = 0;  // images with the same one share vignetting
  ColorImage image;        // as recorded, not undistorted
  Camera camera;
  Rigid3 camera_from_map;
  DepthBuffer depth;    // of the map from this pose
  double weight = 1.0;  // of all its samples, (0, 1]: less for an image that is blurred, for example
};

struct ViewSamplingOptions {
  /// Points farther than this take no colour. (0, inf)
  double max_distance_m = 50.0;
  /// Pixels this close to the border of the image give no colour. [0, inf)
  double border_margin_px = 3.0;
  /// How far behind the depth buffer a point facing the camera still counts as the same surface; a slanted surface
  /// gets more, by 1 / cos(incidence). (0, inf)
  double occlusion_tolerance_m = 0.08;
  /// Background within this distance of something in front takes no colour (the pose is only that good), and the
  /// foreground's own rim there takes it only where no other image shows it better. [0, inf)
  double edge_margin_px = 4.0;
  /// Smallest jump in depth that counts as such an edge, as a share of the distance; comes on top of the tolerance.
  /// [0, inf)
  double edge_jump_ratio = 0.03;
  /// At this distance a sample weighs half of one from close by. (0, inf)
  double reference_distance_m = 5.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("max_distance_m", max_distance_m, "Points farther than this from the camera take no colour, metres.");
    visitor("border_margin_px", border_margin_px, "Pixels this close to the image border give no colour.");
    visitor("occlusion_tolerance_m", occlusion_tolerance_m,
            "How far behind the depth buffer a point still counts as the visible surface, metres.");
    visitor("edge_margin_px", edge_margin_px, "Background this close to something in front takes no colour, pixels.");
    visitor("edge_jump_ratio", edge_jump_ratio,
            "Smallest jump in depth that counts as an edge, share of the distance.");
    visitor("reference_distance_m", reference_distance_m, "At this distance a sample weighs half, metres.");
  }
};

struct ViewSample {
  Rgb color;
  double weight;  // (0, 1]
  double radius;  // distance from the image centre over half the diagonal, [0, 1]; 0 in a panorama
};

/// Answers for one view which colour it gives to a point of the map. Safe from several threads.
class ViewSampler {
 public:
  /// `bearings` are those of the cells of view.depth (CellBearings). Keeps references to all three. Throws Error when
  /// the image is not of the camera's size.
  ViewSampler(const ColorView& view, const std::vector<Eigen::Vector3f>& bearings, const ViewSamplingOptions& options);

  /// The colour of a point (camera frame, metres) and how much it can be trusted: near, seen frontally, in the middle
  /// of the image (vignetting), not on the rim of the foreground. The unit normal (camera frame, either sign) may be
  /// zero where it is not known. Nothing for a point that the image does not show: behind the camera, outside the image
  /// or its margin, too far, hidden, or background next to something in front.
  std::optional<ViewSample> sample(const Eigen::Vector3d& x_in_camera, const Eigen::Vector3d& normal_in_camera) const;

 private:
  enum class Neighborhood { kPlain, kRim, kHidden };
  void find_surroundings();
  Neighborhood look_around(const Eigen::Vector2i& cell, const Eigen::Vector3d& x_in_camera, double range,
                           const Eigen::Vector3d& normal_in_camera, double slack_m) const;
  double radius_of(const Eigen::Vector2d& pixel) const;

  const ColorView& view_;
  const ViewSamplingOptions& options_;
  const std::vector<Eigen::Vector3f>& bearings_;
  Eigen::Vector2d image_center_;
  double radius_per_px_;  // 0 in a panorama
  int reach_cells_;
  /// A cell's range, and the smallest and largest within reach of it, where no surface counts as infinitely far: they
  /// settle most points without a look at every cell.
  struct Surroundings {
    float range = 0.0f;
    float nearest = 0.0f;
    float farthest = 0.0f;
  };
  Image<Surroundings> surroundings_;
};

/// Bilinear interpolation; pixels beyond the border repeat the border.
Rgb bilinear(const ColorImage& image, const Eigen::Vector2d& pixel);

}  // namespace cpplus
