#pragma once

#include <Eigen/Core>
#include <vector>

#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_match.h"
#include "cpplus/refine/pose_guess.h"

namespace cpplus {

/// The matches of one image as linear equations in the perturbation delta (geometry/rigid3.h) of a pose, one a match:
///   r(delta) = n^T (pi(x) - y) + n^T d pi / d delta * delta,
/// Eq. 5 of Cui & Schwertfeger 2022 in pixels, its robust cost w c^2 log(1 + r^2 / (c sigma)^2) (Cauchy's loss of scale
/// c). A sample that leaves the camera model's range has no part in it.
class MatchEquations {
 public:
  /// About the pose from which the matches were projected.
  explicit MatchEquations(const std::vector<EdgeMatch>& matches);
  /// About another one.
  MatchEquations(const std::vector<EdgeMatch>& matches, const Camera& camera, const Rigid3& camera_from_map);

  /// Adds the gradient of half the robust cost at delta, and the matrix of the least squares problem whose weights are
  /// those that the loss leaves at delta: each of its steps lowers the cost of the linear equations.
  void add_normal_equations(const Vector6d& delta, double loss_scale, Matrix6d* information, Vector6d* gradient) const;

  /// Root mean square of what delta shifts the samples across their edges, pixels; 0 without samples.
  double rms_shift_px(const Vector6d& delta) const;

 private:
  void set(Eigen::Index i, const EdgeMatch& match, const Eigen::Vector2d& pixel,
           const Eigen::Matrix<double, 2, 6>& d_pixel_d_delta);

  Eigen::ArrayXd residual_px_;
  Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian_;
  Eigen::ArrayXd variance_px2_;
  Eigen::ArrayXd weight_;
};

struct PoseSolution {
  Rigid3 camera_from_map;
  int iterations = 0;
};

/// Steps after which a pose that is matched anew anyway need not be solved more closely.
inline constexpr int kMaxPoseIterations = 10;

/// Minimises the robust cost of the matches, which were projected from the start pose, and half the squared distance
/// from the guess in its standard deviations: iteratively reweighted least squares on MatchEquations, which are made
/// anew about the solution while it lies so far that the projection bends.
PoseSolution solve_pose(const Camera& camera, const Rigid3& start_camera_from_map,
                        const std::vector<EdgeMatch>& matches, const PoseGuess& guess, double loss_scale,
                        int max_iterations);

}  // namespace cpplus
