#pragma once

#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_match.h"
#include "cpplus/refine/pose_guess.h"

namespace cpplus {

/// Residuals of all matches of one image and of its prior as a function of the perturbation of a base pose
/// (geometry/rigid3.h). Shape: one residual a match, then six of the prior.
///
/// A match: r = n^T (pi(x) - y) / sigma, Eq. 5 of Cui & Schwertfeger 2022, given as sign(r) sqrt(w rho(r^2)) with
/// Cauchy's loss rho(s) = c^2 log(1 + s / c^2), so that their squares add up to the robust cost. A sample that leaves
/// the camera model's range has residual 0. The prior: L^-1 (delta - delta_guess) with L L^T
/// the covariance of the guess.
///
/// Fulfils the requirements of ceres::TinySolver on a function with a Jacobian.
class PoseResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  /// The arguments must outlive this.
  PoseResiduals(const Camera& camera, const Rigid3& base_camera_from_map, const std::vector<EdgeMatch>& matches,
                const PoseGuess& guess, double loss_scale);

  int NumResiduals() const { return static_cast<int>(matches_.size()) + 6; }

  /// `jacobian` (column-major, may be null).
  bool operator()(const double* delta, double* residuals, double* jacobian) const;

 private:
  const Camera& camera_;
  const std::vector<EdgeMatch>& matches_;
  Rigid3 base_camera_from_map_;
  Vector6d prior_mean_;
  Matrix6d prior_root_information_;
  double loss_scale_;
};

struct PoseSolution {
  Rigid3 camera_from_map;
  int iterations = 0;
};

/// Steps after which a pose that is matched anew anyway need not be solved more closely.
inline constexpr int kMaxPoseIterations = 10;

/// Minimises the squares of PoseResiduals from a pose by Levenberg-Marquardt's method.
PoseSolution solve_pose(const Camera& camera, const Rigid3& start_camera_from_map,
                        const std::vector<EdgeMatch>& matches, const PoseGuess& guess, double loss_scale,
                        int max_iterations);

}  // namespace cpplus
