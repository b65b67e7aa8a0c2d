#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/simulate/coarse_poses.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/renderer.h"
#include "cpplus/simulate/simulate.h"

namespace cpplus {

/// What the recordings of all scenes have in common: the sensors, when they record, and what is stated of it.

/// The camera of the options' model and size, its principal point off the middle, as principal points are.
Camera simulated_camera(const SimulateOptions& options);

/// lidar_from_camera: the camera looks along the LiDAR's x axis, slightly turned, a hand's breadth below it.
Rigid3 simulated_extrinsic(uint64_t seed);

/// `count` instants spread evenly over the middle of the way, each moved a little.
std::vector<double> spread_stamps(int count, double duration_s, double jitter, uint64_t seed);

/// The images in the order of their stamps; those that a jolt blurs are spread over the sequence.
std::vector<Shot> plan_shots(double duration_s, const SimulateOptions& options);

/// Everything of an image but its place on the map.
SimulatedImage take_image(const Renderer& renderer, const Shot& shot, size_t index);

std::vector<double> stamps_of(const std::vector<SimulatedImage>& images);

/// Poses of scans as an odometry would state them: wrong by smooth noise.
class StatedPoses {
 public:
  explicit StatedPoses(const SimulateOptions& options);
  /// map_from_lidar at an instant.
  Rigid3 at(double stamp_s, const Rigid3& true_map_from_lidar) const;

 private:
  SmoothNoise noise_;
  double rotation_rad_;
  double translation_m_;
  double scale_;  // a standing LiDAR is tracked better
};

/// The standard levels of wrong starting poses for images of these stamps.
std::vector<CoarsePoses> coarse_levels(const Path& path, const Rigid3& lidar_from_camera,
                                       const std::vector<double>& stamps_s, uint64_t seed);

}  // namespace cpplus
