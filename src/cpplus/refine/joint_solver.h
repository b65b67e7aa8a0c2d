#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/cloud/intensity_match.h"
#include "cpplus/cloud/surface_match.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_evidence.h"
#include "cpplus/refine/imaging.h"
#include "cpplus/refine/joint_terms.h"
#include "cpplus/refine/pose_guess.h"

namespace cpplus {

struct JointOptions {
  /// Rounds of matching edges, each solved to the end. [1, inf)
  int rounds = 6;
  /// Standard deviations of the place where a patch was found in another image: its own, and what all patches of a
  /// plane in a pair of images have in common (error of the plane), pixels. (0, inf)
  double patch_sigma_px = 0.3;
  double plane_sigma_px = 0.3;
  /// Standard deviation of the range scale: by which share of its range the surface that patches lie on is farther than
  /// the map has it (a LiDAR whose ranges are too long, or a trajectory too short). 0 holds it at zero. [0, inf)
  double range_scale_sigma = 0.003;
  /// Standard deviation of the time offset, seconds. (0, inf)
  double time_offset_sigma_s = 0.05;
  /// Poses are less certain by about this factor on their covariance than independent matches would make them: matches
  /// may be wrong, and neighbouring edges, planes and images share the errors of the map. [1, inf)
  double covariance_inflation = 7.0;
  ImagingOptions imaging;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("rounds", rounds, "Rounds of matching edges in the joint solve.");
    visitor("patch_sigma_px", patch_sigma_px, "Standard deviation of a patch's place in another image, pixels.");
    visitor("plane_sigma_px", plane_sigma_px, "What all patches of a plane have in common, pixels.");
    visitor("range_scale_sigma", range_scale_sigma,
            "Standard deviation of the share by which the map's ranges are wrong; 0 = not solved for.");
    visitor("time_offset_sigma_s", time_offset_sigma_s, "Standard deviation of the time offset, seconds.");
    visitor("covariance_inflation", covariance_inflation,
            "Factor on covariances, for errors that matches have in common.");
    visitor.group("imaging", imaging);
  }
};

/// How edges are matched and weighed, as for single images.
struct JointEdgeOptions {
  double first_radius_px = 8.0;
  double last_radius_px = 3.0;
  double loss_scale = 1.5;
  EdgeEvidence::Noise noise;
  /// Of the likelihood ratios that prove a direction of an image (unproven_directions.h): their kernel, pixels, and by
  /// how much their logarithm must fall.
  double kernel_px = 2.5;
  double min_log_gain = 10.0;
};

struct JointImage {
  const Camera* camera = nullptr;  // null: an image without edges and patches needs none
  uint32_t camera_id = 0;
  Rigid3 coarse_camera_from_map;
  Rigid3 camera_from_map;                                    // where the solve starts
  const EdgeEvidence* edges = nullptr;                       // null: it has none
  const std::vector<IntensityMatch>* intensities = nullptr;  // null: none were found yet
  /// Result of the image on its own, where its edges are not at hand.
  std::optional<PoseObservation> observed;
  /// Of the coarse pose, in the camera frame: rad/s, m/s.
  std::optional<Vector6d> velocity_per_s;
};

struct JointProblem {
  std::vector<JointImage> images;
  std::vector<SurfaceMatch> matches;  // indices of images
  /// For each camera, its images in order of time: (time, index).
  std::map<uint32_t, std::vector<std::pair<double, size_t>>> sequences;
};

struct JointPose {
  Rigid3 camera_from_map;  // of the middle row
  /// Perturbation of the camera from the first row to the last (geometry/image_pose.h).
  Vector6d motion = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Zero();  // of the perturbation in geometry/rigid3.h
  /// What everything but the image's own edges (or observation) says of its pose; not inflated, as these are not.
  PoseGuess from_others;
  /// That of `from_others`, inflated as `covariance` is.
  Matrix6d covariance_from_others = Matrix6d::Identity();
  /// Its own edges prove all its directions (unproven_directions.h).
  bool is_proven = false;

  ImagePose image_pose() const { return {camera_from_map, motion}; }
};

struct Estimate {
  double value = 0.0;
  double sigma = 0.0;
};

/// What the images of one camera have wrong in common: their coarse poses, how they are taken, and the map they see.
struct SharedErrors {
  int num_images = 0;
  /// To be added to the stamps of the images, seconds.
  double time_offset_s = 0.0;
  double time_offset_sigma_s = 0.0;
  /// Constant perturbation of the camera (geometry/rigid3.h): rad, rad, rad, m, m, m.
  Vector6d extrinsic = Vector6d::Zero();
  Vector6d extrinsic_sigmas = Vector6d::Zero();
  /// Seconds from the first to the last row; nothing where it is not solved for.
  std::optional<Estimate> readout;
  /// Changes of the given ones, in the order of Camera::params(); empty where they are not solved for.
  std::vector<Estimate> intrinsics;
  /// By which share of its range the surface is farther than the map has it, the same for all cameras; nothing where it
  /// is not solved for or no patches tell.
  std::optional<Estimate> range_scale;
  /// Names of the parameters above of which the data say little: they keep about their prior.
  std::vector<std::string> undetermined;
};

struct JointResult {
  std::vector<JointPose> poses;
  std::map<uint32_t, SharedErrors> shared;  // by camera
  std::map<uint32_t, Camera> cameras;       // with the intrinsics found
  double range_scale = 0.0;                 // surface_match_residual.h
};

/// Solves all images together. The correction c_i of a coarse pose (perturbation, geometry/rigid3.h) is
///
///   c_i = e + v_i t + d_i
///
/// with an extrinsic error e and a time offset t of each camera, the camera's velocity v_i and a drift d_i that changes
/// little from image to image; minimised are, robustly, the distances of map edges to image edges (or to the pose that
/// an image on its own gives; Student's t with 4 degrees of freedom), the places where patches of the map's planes are
/// found in other images (surface_match_residual.h), those where the pattern of LiDAR intensities is found
/// (cloud/intensity_match.h), and the priors of e, t and of the drift (drift_model.h). How large
/// and how smooth that is follows from the data (expectation maximisation), so that errors that are independent from
/// image to image are found to be so. Where patches tell, the scale of the map's ranges is an unknown of all images: a
/// half per cent of it would else pull a long row of images apart. On demand the readout time of a rolling shutter and
/// the intrinsics are unknowns of each camera as well (imaging.h). What an image's own edges do not prove of its pose
/// (unproven_directions.h) is left to the others. Sparse: cost linear in images.
JointResult solve_joint(const JointProblem& problem, const Vector6d& prior_sigmas, const JointEdgeOptions& edges,
                        const JointOptions& options);

}  // namespace cpplus
