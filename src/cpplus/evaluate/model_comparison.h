#pragma once

#include <array>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cpplus/evaluate/checkerboard_residual.h"
#include "cpplus/evaluate/pose_errors.h"
#include "cpplus/evaluate/reprojection_shift.h"
#include "cpplus/evaluate/statistics.h"
#include "cpplus/evaluate/trajectory_error.h"
#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

/// What the estimate of one image is worth.
struct ImageComparison {
  std::string name;
  PoseError pose;
  ReprojectionShift shift;  // num_points 0 where no surface is known
  double checkerboard_px;   // Eq. 6, CP+; NaN where no board is sighted
};

/// Two models of the same images side by side. Statistics leave out the images without the figure (their `count` says
/// how many have it).
struct ModelComparison {
  std::vector<ImageComparison> images;  // in both models, by name
  std::vector<std::string> only_in_estimate;
  std::vector<std::string> only_in_reference;

  SampleStatistics rotation_deg;
  SampleStatistics translation_m;
  SampleStatistics shift_px;           // of the images' mean shifts
  std::array<double, 3> shift_shares;  // of the images' mean shifts, below kSuccessThresholdsPx
  SampleStatistics checkerboard_px;

  struct Absolute {
    TrajectoryAlignment alignment;
    std::optional<TrajectoryError> error;  // nothing where the camera centres do not determine the alignment
  };
  std::vector<Absolute> absolute;  // ATE, one for each alignment

  struct Relative {
    double length_m;  // of the stretches of the reference's path; 0 = from each image to the next one
    TrajectoryError error;
  };
  std::vector<Relative> relative;  // RPE: image to image, then 10, 25 and 50 % of the whole path
};

/// Surface points (map frame, metres) that the reference pose of an image truly sees; may be empty.
using VisiblePointsOfImage = std::function<std::vector<Eigen::Vector3d>(const PosedImage& reference, const Camera&)>;

/// Compares the images that both models hold, matched by name, except those in `excluded`. Projections use the camera
/// of the reference. ATE and RPE take the images in the order of their names.
/// Throws Error for a name that a model has twice and for an image whose camera is not in the model.
ModelComparison compare_models(const SparseModel& estimate, const SparseModel& reference,
                               const VisiblePointsOfImage& visible_points, const std::vector<Checkerboard>& boards,
                               const std::set<std::string>& excluded = {});

}  // namespace cpplus
