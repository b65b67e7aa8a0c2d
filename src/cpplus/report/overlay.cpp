#include "cpplus/report/overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "cpplus/report/render_cloud.h"

namespace cpplus {
namespace {

constexpr double kStepPx = 4.0;
/// A jump this long between neighbouring samples is the seam of a panorama, not a line.
constexpr double kMaxLinkPx = 50.0;
constexpr int kMaxSteps = 2000;
constexpr int kSubpixelBits = 4;

/// The pixels of an image seen as an OpenCV matrix (channels in the order red, green, blue).
cv::Mat as_mat(ColorImage* image) { return {image->height, image->width, CV_8UC3, image->pixels.data()}; }

cv::Scalar as_scalar(const Rgb& color) { return {double(color[0]), double(color[1]), double(color[2])}; }

double distance_to_segment(const Eigen::Vector3d& x, const OverlaySegment& segment) {
  const Eigen::Vector3d along = segment.end - segment.begin;
  const double length_squared = along.squaredNorm();
  const double t = length_squared > 0.0 ? std::clamp((x - segment.begin).dot(along) / length_squared, 0.0, 1.0) : 0.0;
  return (segment.begin + t * along - x).norm();
}

/// Enough steps that none is longer than about kStepPx even where the segment is nearest.
int num_steps(const OverlaySegment& segment, const Camera& camera, const Eigen::Vector3d& center_in_map) {
  const double nearest_m = std::max(0.05, distance_to_segment(center_in_map, segment));
  const double length_px = (segment.end - segment.begin).norm() / nearest_m * camera.pixels_per_radian();
  return std::clamp(static_cast<int>(std::ceil(length_px / kStepPx)), 1, kMaxSteps);
}

}  // namespace

void draw_segments(const std::vector<OverlaySegment>& segments, const Camera& camera, const Rigid3& camera_from_map,
                   const Rgb& color, ColorImage* image) {
  cv::Mat mat = as_mat(image);
  const Eigen::Vector3d center = camera_center(camera_from_map);
  const int thickness = std::max(1, image->width / 800);
  const auto fixed_point = [](const Eigen::Vector2d& pixel) {
    return cv::Point(static_cast<int>(std::lround(pixel.x() * (1 << kSubpixelBits))),
                     static_cast<int>(std::lround(pixel.y() * (1 << kSubpixelBits))));
  };
  for (const OverlaySegment& segment : segments) {
    const int steps = num_steps(segment, camera, center);
    std::optional<Eigen::Vector2d> previous;
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      std::optional<Eigen::Vector2d> pixel =
          camera.project(camera_from_map * ((1.0 - t) * segment.begin + t * segment.end));
      if (pixel && !camera.in_image(*pixel, -kMaxLinkPx)) pixel.reset();
      if (pixel && previous && (*pixel - *previous).norm() < kMaxLinkPx) {
        cv::line(mat, fixed_point(*previous), fixed_point(*pixel), as_scalar(color), thickness, cv::LINE_AA,
                 kSubpixelBits);
      }
      previous = pixel;
    }
  }
}

ColorImage overlay_background(const ColorImage& image) {
  ColorImage result = image;
  for (Rgb& pixel : result.pixels) {
    const double gray = 0.299 * pixel[0] + 0.587 * pixel[1] + 0.114 * pixel[2];
    pixel.fill(static_cast<uint8_t>(std::lround(0.6 * gray)));
  }
  return result;
}

void draw_caption(const std::string& caption, ColorImage* image) {
  if (caption.empty() || image->empty()) return;
  cv::Mat mat = as_mat(image);
  const double scale = std::max(0.4, image->width / 1300.0);
  int baseline = 0;
  const cv::Size size = cv::getTextSize(caption, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &baseline);
  const int pad = size.height / 2;
  cv::rectangle(mat, cv::Rect(0, 0, size.width + 2 * pad, size.height + baseline + pad), cv::Scalar(20, 20, 20),
                cv::FILLED);
  cv::putText(mat, caption, cv::Point(pad, size.height + pad), cv::FONT_HERSHEY_SIMPLEX, scale,
              cv::Scalar(255, 255, 255), 1, cv::LINE_AA);
}

ColorImage before_after_overlay(const ColorImage& image, const std::vector<OverlaySegment>& segments,
                                const Camera& camera, const Rigid3& before_camera_from_map,
                                const Rigid3& after_camera_from_map, const std::string& before_caption,
                                const std::string& after_caption) {
  ColorImage before = overlay_background(image);
  ColorImage after = before;
  draw_segments(segments, camera, before_camera_from_map, kBeforeColor, &before);
  draw_segments(segments, camera, after_camera_from_map, kAfterColor, &after);
  draw_caption(before_caption, &before);
  draw_caption(after_caption, &after);
  return side_by_side(before, after);
}

}  // namespace cpplus
