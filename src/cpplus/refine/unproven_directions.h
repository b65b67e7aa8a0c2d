#pragma once

#include <Eigen/Core>
#include <functional>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/joint_terms.h"

namespace cpplus {

/// Perturbations of a pose, one a column: unit vectors in standard deviations of its prior.
using PoseDirections = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// The directions of a pose that an image's edges seem to know a little, but no better than chance would have it. Down
/// a bare corridor a few false edges of the map, and spots on its walls that are taken for them, tell all images the
/// same wrong place; each image's likelihood is then as high a long way along the corridor. Looked at are the
/// eigenvectors of the information, in standard deviations of the prior, that are not known well; proven is one when
/// the logarithm of the likelihood ratio falls by at least min_log_gain towards either side of the pose.
/// log_ratio(delta): that of a perturbation.
PoseDirections unproven_directions(const Matrix6d& information, const Vector6d& prior_sigmas, double min_log_gain,
                                   const std::function<double(const Vector6d& delta)>& log_ratio);

/// Lets the pose move along the directions at no cost to the term: what the term says of them is lost. So that it does
/// not come back through the others, which differ a little from image to image (a millimetre sideways is a decimetre
/// along a corridor that the camera looks down a little askew), these are left uncertain by what the map's edges near
/// one image have wrong in common. Nothing is done without directions.
void free_directions(const PoseDirections& directions, const Vector6d& prior_sigmas, EvidenceTerm* term);

}  // namespace cpplus
