#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A straight edge in the map, metres.
struct OverlaySegment {
  Eigen::Vector3d begin = Eigen::Vector3d::Zero();
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
};

inline constexpr Rgb kBeforeColor = {255, 60, 50};
inline constexpr Rgb kAfterColor = {60, 230, 80};

/// Draws segments over an image. They are followed in short steps through the camera model, so that they bend with
/// the distortion; parts that do not project are left out. Occlusion is not tested: pass only the edges to be seen.
void draw_segments(const std::vector<OverlaySegment>& segments, const Camera& camera, const Rigid3& camera_from_map,
                   const Rgb& color, ColorImage* image);

/// The image as grey, darkened so that coloured lines stand out.
ColorImage overlay_background(const ColorImage& image);

/// A line of text in the top left corner, on a dark strip.
void draw_caption(const std::string& caption, ColorImage* image);

/// The picture to judge a refinement by: the map's edges over the image under the pose before (left, red) and after
/// (right, green).
ColorImage before_after_overlay(const ColorImage& image, const std::vector<OverlaySegment>& segments,
                                const Camera& camera, const Rigid3& before_camera_from_map,
                                const Rigid3& after_camera_from_map, const std::string& before_caption = "before",
                                const std::string& after_caption = "after");

}  // namespace cpplus
