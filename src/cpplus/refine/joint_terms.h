#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "cpplus/cloud/intensity_match.h"
#include "cpplus/cloud/surface_match.h"
#include "cpplus/refine/edge_match.h"
#include "cpplus/refine/imaging.h"

namespace cpplus {

/// Robust cost of some measurements, and half its derivatives by what they depend on: h is the information matrix of
/// Gauss and Newton with the weights that the losses leave, g the gradient.
struct EvidenceTerm {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  double cost = 0.0;

  /// Zero, for so many unknowns.
  explicit EvidenceTerm(int size = 6) : h(Eigen::MatrixXd::Zero(size, size)), g(Eigen::VectorXd::Zero(size)) {}
};

/// What one image says of its pose, without the prior: information of the perturbation (geometry/rigid3.h).
struct PoseObservation {
  Rigid3 camera_from_map;
  Matrix6d information = Matrix6d::Zero();
};

/// One image in the joint solve: where it stands, and how its camera moves (rad/s, m/s, its own frame).
struct ImageState {
  Rigid3 camera_from_map;
  Vector6d velocity_per_s = Vector6d::Zero();
  const Imaging* imaging = nullptr;

  ImagePose pose() const { return imaging->pose(camera_from_map, velocity_per_s); }
};

/// The pose that an image found on its own. Unknowns: the perturbation of its pose. Gaussian up to the square that six
/// numbers have on average, beyond it Student's t with 4 degrees of freedom.
EvidenceTerm observation_term(const PoseObservation& observed, const Matrix6d& information, const Rigid3& pose);

/// Distances of an image's map edges to the image edges that they match, with Cauchy's loss. Unknowns: the perturbation
/// of its pose, then the parameters of its Imaging. matched_readout_s is the readout time with which the matches were
/// made.
EvidenceTerm edge_term(const std::vector<EdgeMatch>& matches, const ImageState& image, double matched_readout_s,
                       double loss_scale);

/// Adds the distances of spots of the map from where the image shows their intensities, with Cauchy's loss. Unknowns as
/// in edge_term().
void add_intensity_matches(const std::vector<IntensityMatch>& matches, const ImageState& image, double loss_scale,
                           EvidenceTerm* term);

/// Patches that two images share.
struct SharedPatches {
  size_t a = 0, b = 0;  // images
  std::vector<const SurfaceMatch*> matches;
  std::vector<double> weights;
};

struct PatchNoise {
  double variance_px2 = 0.18;
  double loss_scale = 1.5;
};

/// Distances of patches from where they are expected in the other image, with Cauchy's loss. Unknowns: the
/// perturbations of both poses, then the parameters of the Imaging of a, then of b (also where they are one camera),
/// then the range scale (surface_match_residual.h), if there is one.
EvidenceTerm patch_term(const SharedPatches& patches, const ImageState& a, const ImageState& b,
                        const std::optional<double>& range_scale, const PatchNoise& noise);

}  // namespace cpplus
