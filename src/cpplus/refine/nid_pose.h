#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "cpplus/core/image.h"
#include "cpplus/core/options.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct NidOptions {
  /// Bins of the joint histogram on each side. [2, 256]
  int bins = 16;
  /// How often the visible points are chosen anew and the pose is looked for from the last one. [1, inf)
  int rounds = 3;
  /// Most evaluations of the distance in a round. [8, inf)
  int max_evaluations = 300;
  /// First steps of the simplex about each axis and along each axis; halved from round to round. (0, inf)
  double rotation_step_deg = 0.5;
  double translation_step_m = 0.05;
  /// Points farther than this from the camera are not looked at, metres. (0, inf)
  double max_distance_m = 40.0;
  /// A point counts as hidden when it lies this far behind the nearest surface, metres. [0, inf)
  double occlusion_margin_m = 0.1;
  /// Of more visible points every so manieth is taken. [1, inf)
  int max_points = 30000;
  /// Fewest visible points for a result. [1, inf)
  int min_points = 500;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("bins", bins, "Bins of the joint histogram on each side.");
    visitor("rounds", rounds, "How often the visible points are chosen anew.");
    visitor("max_evaluations", max_evaluations, "Most evaluations of the distance in a round.");
    visitor("rotation_step_deg", rotation_step_deg, "First step of the simplex about each axis, degrees.");
    visitor("translation_step_m", translation_step_m, "First step of the simplex along each axis, metres.");
    visitor("max_distance_m", max_distance_m, "Points farther than this from the camera are not looked at, metres.");
    visitor("occlusion_margin_m", occlusion_margin_m, "A point this far behind the nearest surface is hidden, metres.");
    visitor("max_points", max_points, "Of more visible points an even choice is taken.");
    visitor("min_points", min_points, "Fewest visible points for a result.");
  }
};

/// A map point with its LiDAR intensity, spread evenly over [0, 1] (equalise_intensities).
struct NidPoint {
  Eigen::Vector3d x_in_map;
  float intensity = 0.0f;
};

struct NidResult {
  bool improved = false;   // the distance fell
  std::string reason;      // why it is the coarse pose; empty when improved
  Rigid3 camera_from_map;  // the pose found, or the coarse one unchanged
  double before = 1.0;     // distance at the coarse pose and at the result, on the points of the last round
  double after = 1.0;
  int num_points = 0;   // of the last round
  int evaluations = 0;  // all rounds
};

/// The share of the values that lie below each value, equal ones counted half: in [0, 1], evenly spread whatever the
/// sensor's unit. Same length and order. NaN stays NaN.
std::vector<float> equalise_intensities(const std::vector<float>& intensities);

/// Normalised information distance of a joint histogram (square, non-negative, any sum):
///
///   NID = (2 H(X,Y) - H(X) - H(Y)) / H(X,Y)
///
/// 0 where each signal gives the other, 1 where they are independent, and 1 for an empty histogram or a single bin.
double normalised_information_distance(const Eigen::MatrixXd& joint_histogram);

/// Distance between the intensities of points and the brightness of the pixels that they fall on. Each point votes for
/// its own bin of intensity and, with the weights of a cubic B-spline, for the bins of the 4x4 pixels around it, so
/// that the distance is smooth in the pose. 1 where fewer than half of the points fall into the image.
double nid_at(const std::vector<NidPoint>& points, const Camera& camera, const Rigid3& camera_from_map,
              const GrayImage& image, int bins);

/// Aligns an image with the LiDAR intensity of the map in the manner of Koide et al. 2023 (General, single-shot,
/// target-less, and automatic LiDAR-camera extrinsic calibration toolbox): the pose of least normalised information
/// distance by Nelder-Mead, the visible points (`visible_points` gives them for a pose) chosen anew each round. A
/// baseline for comparison: without a prior, and with no verdict but that the distance fell.
NidResult refine_pose_nid(const Camera& camera, const Rigid3& coarse_camera_from_map, const GrayImage& image,
                          const std::function<std::vector<NidPoint>(const Rigid3& camera_from_map)>& visible_points,
                          const NidOptions& options);

}  // namespace cpplus
