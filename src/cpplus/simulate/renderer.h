#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/simulate/lighting.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/tracer.h"

namespace cpplus {

struct RenderOptions {
  /// Samples a pixel where it is smooth; four times as many where it is not. [1, 64], rounded up to a square
  int samples_per_pixel = 4;
  /// Standard deviation of the sensor noise at mid grey, grey levels of 255. [0, 50]
  double noise_grey = 1.5;
  /// Spread of the exposure between images, natural logarithm, standard deviation. [0, 1]
  double exposure_sigma = 0.1;
  /// Time from the first to the last row of a rolling shutter, seconds; 0 = global shutter. [0, 0.2]
  double readout_s = 0.0;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("samples_per_pixel", samples_per_pixel, "Samples a pixel; four times as many at edges. [1, 64]");
    visitor("noise_grey", noise_grey, "Sensor noise, grey levels. [0, 50]");
    visitor("exposure_sigma", exposure_sigma, "Spread of the exposure between images, natural logarithm. [0, 1]");
    visitor("readout_s", readout_s, "Rolling shutter: seconds from the first to the last row; 0 = global. [0, 0.2]");
  }
};

/// How one image is taken. The stamp is the middle of the exposure of the middle row.
struct Shot {
  double stamp_s = 0.0;
  /// Linear motion blur of a jolted camera: length (px) and direction (rad, 0 = along +x) at the image centre.
  double blur_px = 0.0;
  double blur_direction_rad = 0.0;
  uint64_t seed = 0;
};

/// Takes pictures of a scene from a moving camera: unproject() rays, supersampled, procedural texture, sun with sharp
/// shadows, soft light, automatic exposure, sensor noise.
class Renderer {
 public:
  /// References must outlive the renderer.
  Renderer(const Tracer& tracer, const SoftLight& light, const Camera& camera, const Path& path,
           const Rigid3& lidar_from_camera, const RenderOptions& options);

  /// camera_from_map at an instant.
  Rigid3 camera_from_map(double time_s) const;

  /// Pixel of a map point in the middle of the exposure, at the instant its row is read out; nothing where the camera
  /// model gives none.
  std::optional<Eigen::Vector2d> project(const Shot& shot, const Eigen::Vector3d& x_in_map) const;

  ColorImage render(const Shot& shot) const;

  /// Distance along the ray of the static scene at pixels (step * i + offset, step * j + offset), 0 = none. Rays go
  /// through the same pixels as the image's (rolling shutter included).
  RangeImage range(const Shot& shot, int step, double offset) const;

  /// Share of the pixels that show a moving body, on the same kind of grid.
  double moving_share(const Shot& shot, int step) const;

 private:
  struct RowPose {
    Eigen::Matrix3f map_from_camera = Eigen::Matrix3f::Identity();
    Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  };

  RowPose pose_at(const Shot& shot, double row, double shutter) const;
  bool bearing(double x, double y, Eigen::Vector3f* bearing_in_camera) const;
  double row_time(const Shot& shot, double row) const;
  Eigen::Vector3f radiance(const RowPose& pose, const BodyPoses& bodies,
                           const Eigen::Vector3f& bearing_in_camera) const;
  float metered_gain(const Shot& shot) const;
  void render_row(const Shot& shot, float gain, int row, Image<Eigen::Vector3f>* linear) const;
  Eigen::Vector3f sample_cells(const Shot& shot, const RowPose& pose, const BodyPoses& bodies, float gain, int x, int y,
                               int side, int round, float* contrast) const;

  const Tracer& tracer_;
  const SoftLight& light_;
  const Camera& camera_;
  const Path& path_;
  Rigid3 lidar_from_camera_;
  RenderOptions options_;
  // Bearings at pixel corners (x - 0.5, y - 0.5); NaN where the model gives none.
  Image<Eigen::Vector3f> corner_bearings_;
};

}  // namespace cpplus
