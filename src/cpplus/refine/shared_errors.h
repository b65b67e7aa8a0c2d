#pragma once

#include <optional>
#include <vector>

#include "cpplus/refine/pose_sequence.h"

namespace cpplus {

/// What the coarse poses of all images of one camera have wrong in common.
struct SharedErrors {
  int num_images = 0;
  /// To be added to the stamps of the images, seconds.
  double time_offset_s = 0.0;
  double time_offset_sigma_s = 0.0;
  /// Constant perturbation of the camera (geometry/rigid3.h): rad, rad, rad, m, m, m.
  Vector6d extrinsic = Vector6d::Zero();
  Vector6d extrinsic_sigmas = Vector6d::Zero();
};

/// Weighted least squares of  correction_i = extrinsic + velocity_i * time_offset  over the usable images, with the
/// priors of the coarse pose and of 0.1 s; Student's t weights (4 degrees of freedom). `velocities_per_s` (rad/s, m/s,
/// in the camera frame) has one entry an image; where it is missing the image takes no part. Standard deviations are
/// scaled by the misfit. Nothing with fewer than min_images images.
std::optional<SharedErrors> estimate_shared_errors(const std::vector<PoseCorrection>& corrections,
                                                   const std::vector<std::optional<Vector6d>>& velocities_per_s,
                                                   const Vector6d& prior_sigmas, const PoseSequenceOptions& options);

}  // namespace cpplus
