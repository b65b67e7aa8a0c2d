#pragma once

#include <Eigen/Core>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/refine/edge_match.h"

namespace cpplus {

/// What errors of the edges' directions feign.
///
/// A point that moves along its edge stays on it, but on an edge whose direction is taken to be a little different it
/// seems to leave it. Where all edges run one way, down a bare corridor, nothing else tells how far along one stands:
/// the errors, in the square of which there is no cancelling, then pass for information, and since the map's edges are
/// the same in all images, all images together believe the same wrong place. The errors' information has the mean
/// sum w q q', q = slip' dx/d(perturbation) / sigma, with the slip of EdgeMatch; where an image's information is not
/// several times as large, it is no information.
class DirectionErrors {
 public:
  /// One match: x_in_camera, the rotation of its pose and the weight that the losses leave it.
  void add(const EdgeMatch& match, const Eigen::Vector3d& x_in_camera, const Eigen::Matrix3d& camera_from_map,
           double weight);

  /// Takes their part out of half the derivatives of a robust cost by unknowns of which the first six are the
  /// perturbation of the pose: information h, gradient g; and out of the cost what a move along the directions that are
  /// not known would take off it. As if these directions were free for this image.
  void discount(Eigen::MatrixXd* h, Eigen::VectorXd* g, double* cost) const;

  /// The information of a pose without their part.
  Matrix6d discounted(const Matrix6d& information) const;

 private:
  Matrix6d information_ = Matrix6d::Zero();
};

}  // namespace cpplus
