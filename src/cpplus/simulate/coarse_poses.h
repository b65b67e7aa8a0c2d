#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cpplus/core/random.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// A random function of time, R -> R^6, smooth, zero mean, unit variance in each component: a few sinusoids.
class SmoothNoise {
 public:
  SmoothNoise(uint64_t seed, double shortest_period_s, double longest_period_s);
  Vector6d at(double time_s) const;

 private:
  static constexpr int kWaves = 5;
  Eigen::Matrix<double, 6, kWaves> phase_rad_;
  Eigen::Matrix<double, 6, kWaves> rate_;  // rad/s
};

struct CoarseOptions {
  std::string name;
  /// Root mean square over the sequence of the rotation angle and of the displacement of the camera centre.
  double rms_rotation_deg = 0.3;
  double rms_translation_m = 0.03;
  /// Clock error: the poses are those of the true stamp plus this. Made smaller where its share of the error alone
  /// would exceed half of the level.
  double time_offset_s = 0.02;
  /// Parts of the rest: a wrong extrinsic (constant in the camera frame), a slow smooth drift (in the map frame), and
  /// noise of each image. Only their ratios matter.
  double extrinsic_share = 1.0;
  double drift_share = 0.6;
  double noise_share = 0.15;
  double shortest_drift_period_s = 8.0;
  double longest_drift_period_s = 40.0;
  uint64_t seed = 1;
};

/// A level of wrong starting poses.
struct CoarsePoses {
  std::string name;
  double time_offset_s = 0.0;
  double rms_rotation_deg = 0.0;
  double rms_translation_m = 0.0;
  std::vector<Rigid3> camera_from_map;  // in the order of the stamps
};

/// Disturbs true poses; `camera_from_map_at` gives them at any instant (map frame to camera, seconds).
CoarsePoses make_coarse_poses(const std::function<Rigid3(double)>& camera_from_map_at,
                              const std::vector<double>& stamps_s, const CoarseOptions& options);

/// The levels small (0.3 deg, 3 cm), medium (0.8 deg, 8 cm) and large (2 deg, 20 cm).
std::vector<CoarseOptions> standard_coarse_levels(uint64_t seed);

}  // namespace cpplus
