#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/adjust/scan_patches.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct SolveOptions {
  /// How far the true surfaces of a patch are from a plane, metres: bounds the weight of many points. (0, inf)
  double plane_sigma_m = 0.005;
  /// A priori standard deviation of a scan's correction, per axis. (0, inf)
  double prior_sigma_m = 0.1;
  double prior_sigma_deg = 0.5;
  /// And of the difference of the corrections of consecutive scans. (0, inf)
  double smooth_sigma_m = 0.02;
  double smooth_sigma_deg = 0.1;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("plane_sigma_m", plane_sigma_m, "How far true surfaces are from the plane of a patch, metres.");
    visitor("prior_sigma_m", prior_sigma_m, "A priori standard deviation of a scan's correction, metres per axis.");
    visitor("prior_sigma_deg", prior_sigma_deg, "A priori standard deviation of its rotation, degrees per axis.");
    visitor("smooth_sigma_m", smooth_sigma_m, "Of the difference of consecutive scans' corrections, metres per axis.");
    visitor("smooth_sigma_deg", smooth_sigma_deg, "Of their rotation, degrees per axis.");
  }
};

/// What is solved for: map_from_lidar by scan, and the poses that came in, which the priors pull to.
struct ScanPoses {
  std::vector<Rigid3> input;
  std::vector<Rigid3> current;
};

/// Rotation vector (rad, map frame) and displacement of the sensor (metres, map frame) from one pose to the other.
Vector6d pose_correction(const Rigid3& from_map_from_lidar, const Rigid3& to_map_from_lidar);

struct CorrectionStep {
  double largest_m = 0.0;    // of the last step's displacements
  double largest_rad = 0.0;  // of its rotations
};

/// Moves the current poses to the minimum of the patches' cost (made at the current poses), planes and weights found
/// anew in each of a few steps. Returns the whole way from the poses it was called with.
CorrectionStep solve_corrections(const std::vector<ScanPatch>& patches, const SolveOptions& options, ScanPoses* poses);

/// Covariance of the scans' corrections without their common rigid motion, which nothing but the priors holds: six rows
/// a scan, rotation (rad) then displacement (m), map frame. `prior` is the one before the scans were looked at.
struct CorrectionCovariance {
  Eigen::MatrixXd posterior;
  Eigen::MatrixXd prior;
};
CorrectionCovariance correction_covariance(const std::vector<ScanPatch>& patches, const SolveOptions& options,
                                           const ScanPoses& poses);

}  // namespace cpplus
