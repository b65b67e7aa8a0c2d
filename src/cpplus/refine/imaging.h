#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/image_pose.h"

namespace cpplus {

struct ImagingOptions {
  /// Standard deviation of the time from the first to the last row of a rolling shutter, around zero, seconds; 0 holds
  /// it at zero (global shutter). [0, inf)
  double readout_sigma_s = 0.02;
  /// Solve for the cameras' intrinsics as well.
  bool intrinsics = false;
  /// Standard deviations of the given intrinsics: of focal lengths as a share of them, of the principal point in
  /// pixels, of each coefficient of the distortion. (0, inf)
  double focal_sigma_ratio = 0.01;
  double principal_point_sigma_px = 8.0;
  double distortion_sigma = 0.02;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("readout_sigma_s", readout_sigma_s,
            "Standard deviation of a rolling shutter's first-to-last-row time, seconds; 0 = global shutter.");
    visitor("intrinsics", intrinsics, "Solve for the cameras' intrinsics as well.");
    visitor("focal_sigma_ratio", focal_sigma_ratio, "Standard deviation of focal lengths, share of them.");
    visitor("principal_point_sigma_px", principal_point_sigma_px, "Standard deviation of the principal point, pixels.");
    visitor("distortion_sigma", distortion_sigma, "Standard deviation of each coefficient of the distortion.");
  }
};

/// How the images of one camera are taken, apart from where: the parameters that all of them share and that their
/// pixels depend on directly. In order: the readout time (where it is solved for), then the intrinsics (likewise), in
/// the order of Camera::params().
class Imaging {
 public:
  /// Starts at readout 0 and the given intrinsics. Without velocities the readout cannot be told.
  Imaging(const Camera& camera, bool has_velocities, const ImagingOptions& options);

  int num_parameters() const { return static_cast<int>(values_.size()); }
  bool has_readout() const { return has_readout_; }
  int num_intrinsics() const { return num_parameters() - (has_readout_ ? 1 : 0); }
  const Eigen::VectorXd& values() const { return values_; }
  /// Of the prior, around the values of the start.
  const Eigen::VectorXd& prior_sigmas() const { return prior_sigmas_; }
  const Eigen::VectorXd& prior_means() const { return prior_means_; }
  /// Throws Error for intrinsics that make no camera.
  void set_values(const Eigen::VectorXd& values);

  const Camera& camera() const { return camera_; }
  double readout_s() const { return has_readout_ ? values_(0) : 0.0; }
  /// velocity_per_s: of the camera in its own frame, rad/s and m/s.
  ImagePose pose(const Rigid3& camera_from_map, const Vector6d& velocity_per_s) const {
    return {camera_from_map, readout_s() * velocity_per_s};
  }

  /// The camera with intrinsic k lower (0) and higher (1) by step(k), for derivatives.
  const std::array<Camera, 2>& neighbors(int k) const { return neighbors_[static_cast<size_t>(k)]; }
  double step(int k) const { return steps_[static_cast<size_t>(k)]; }

 private:
  void update_cameras();

  Camera camera_;
  bool has_readout_ = false;
  Eigen::VectorXd values_;
  Eigen::VectorXd prior_sigmas_;
  Eigen::VectorXd prior_means_;
  std::vector<double> steps_;
  std::vector<std::array<Camera, 2>> neighbors_;
};

}  // namespace cpplus
