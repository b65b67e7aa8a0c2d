#pragma once

#include <optional>
#include <vector>

#include "cpplus/core/options.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

struct PoseSequenceOptions {
  /// The covariances of single images are too small by about this factor, as matches may be wrong. [1, inf)
  double covariance_inflation = 4.0;
  /// Least standard deviations of a prediction from the neighbours. (0, inf)
  double min_rotation_sigma_deg = 0.1;
  double min_translation_sigma_m = 0.01;
  /// Fewest refined images from which others are predicted. [3, inf)
  int min_images = 4;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("covariance_inflation", covariance_inflation, "Factor on the covariances of single images.");
    visitor("min_rotation_sigma_deg", min_rotation_sigma_deg, "Least rotation sigma of a prediction, degrees.");
    visitor("min_translation_sigma_m", min_translation_sigma_m, "Least translation sigma of a prediction, metres.");
    visitor("min_images", min_images, "Fewest refined images from which others are predicted.");
  }
};

/// What one image says of the error of its coarse pose, as a perturbation of it (geometry/rigid3.h).
struct PoseCorrection {
  double time = 0.0;  // seconds, or the place in the sequence
  Vector6d correction = Vector6d::Zero();
  Matrix6d information = Matrix6d::Zero();  // of the data alone
  bool usable = false;                      // false: it was not refined and tells nothing
};

struct PosePrediction {
  Vector6d mean = Vector6d::Zero();
  Vector6d sigmas = Vector6d::Ones();
  double consistency = 0.0;  // squared Mahalanobis distance of the image's own correction; 0 if not usable
};

/// Predicts the correction of each image from all the others: the errors of coarse poses (extrinsics, time offset,
/// drift) change slowly along a trajectory. Model: a random walk of the correction, started from the prior, observed by
/// each usable image; its step size is the one under which the observations are most likely, so that errors that are
/// independent from image to image are found to be so and predict nothing. Forward and backward filters in information
/// form; images that contradict their neighbours lose weight (Student's t, 4 degrees of freedom). Linear in the images.
/// `corrections` ascending in time; empty result: fewer than min_images usable.
std::vector<PosePrediction> predict_corrections(const std::vector<PoseCorrection>& corrections,
                                                const Vector6d& prior_sigmas, const PoseSequenceOptions& options);

}  // namespace cpplus
