#include "cpplus/refine/joint_terms.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "cpplus/geometry/perturbed_pixel.h"
#include "cpplus/refine/direction_errors.h"
#include "cpplus/refine/surface_match_residual.h"

namespace cpplus {
namespace {

constexpr double kStudentDegrees = 4.0;
constexpr int kMaxParameters = 13;  // of an Imaging: the readout and FULL_OPENCV's twelve

double cauchy_cost(double squared, double scale) { return scale * scale * std::log1p(squared / (scale * scale)); }
double cauchy_weight(double squared, double scale) { return 1.0 / (1.0 + squared / (scale * scale)); }

// Rows on the stack.
using SpotRows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 6 + kMaxParameters>;
using EdgeRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 6 + kMaxParameters>;
using PatchRows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 13 + 2 * kMaxParameters>;

// Derivative of the pixel of a point (camera frame) by an intrinsic.
Eigen::Vector2d by_intrinsic(const Imaging& imaging, int k, const Eigen::Vector3d& x_in_camera) {
  const auto low = imaging.neighbors(k)[0].project(x_in_camera);
  const auto high = imaging.neighbors(k)[1].project(x_in_camera);
  return low && high ? Eigen::Vector2d((*high - *low) / (2.0 * imaging.step(k))) : Eigen::Vector2d::Zero();
}

// Derivatives of the residual by the parameters of the Imaging of a (which = 0) or b.
void add_imaging_derivatives(const SurfaceMatch& match, const SurfaceMatchResidual& r, const ImageState& a,
                             const ImageState& b, double range_scale, int which, Eigen::Index column, PatchRows* rows) {
  const ImageState& image = which == 0 ? a : b;
  const Imaging& imaging = *image.imaging;
  if (imaging.has_readout()) {
    const Eigen::Vector2d& pixel = which == 0 ? match.pixel_a : match.pixel_b;
    const double fraction = row_fraction(pixel.y(), imaging.camera().height());
    rows->col(column++) = (which == 0 ? r.by_a : r.by_b) * (fraction * image.velocity_per_s);
  }
  for (int k = 0; k < imaging.num_intrinsics(); ++k) {
    const auto residual_with = [&](const Camera& camera) {
      return surface_match_residual(match, which == 0 ? camera : a.imaging->camera(), a.pose(),
                                    which == 0 ? b.imaging->camera() : camera, b.pose(), range_scale);
    };
    const auto low = residual_with(imaging.neighbors(k)[0]);
    const auto high = residual_with(imaging.neighbors(k)[1]);
    rows->col(column++) = low && high ? Eigen::Vector2d((high->residual - low->residual) / (2.0 * imaging.step(k)))
                                      : Eigen::Vector2d::Zero();
  }
}

}  // namespace

EvidenceTerm observation_term(const PoseObservation& observed, const Matrix6d& information, const Rigid3& pose) {
  const Vector6d difference = camera_difference(observed.camera_from_map, pose);
  const double squared = difference.dot(information * difference);
  const double beyond = std::max(0.0, squared - 6.0) / (kStudentDegrees + 6.0);
  EvidenceTerm term;
  term.h = information / (1.0 + beyond);
  term.g = term.h * difference;
  term.cost = std::min(squared, 6.0) + (kStudentDegrees + 6.0) * std::log1p(beyond);
  return term;
}

EvidenceTerm edge_term(const std::vector<EdgeMatch>& matches, const ImageState& image, double matched_readout_s,
                       double loss_scale) {
  const Imaging& imaging = *image.imaging;
  EvidenceTerm term(6 + imaging.num_parameters());
  // What the matches do not know yet of the motion over the rows.
  const ImagePose pose(image.camera_from_map, (imaging.readout_s() - matched_readout_s) * image.velocity_per_s);
  const Eigen::Matrix3d rotation = image.camera_from_map.rotation.toRotationMatrix();
  DirectionErrors direction_errors;
  EdgeRow j(6 + imaging.num_parameters());
  for (const EdgeMatch& m : matches) {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> d_pixel_d_x;
    const Eigen::Vector3d x = pose.at(m.row_fraction) * m.x_in_map;
    if (!imaging.camera().project(x, &pixel, &d_pixel_d_x)) continue;
    const double r = m.normal.dot(pixel - m.pixel) / m.sigma_px;
    const Eigen::RowVector3d slope = m.normal.transpose() * d_pixel_d_x / m.sigma_px;
    j.head<3>() = slope.cross(x.transpose());
    j.segment<3>(3) = -slope;
    Eigen::Index column = 6;
    if (imaging.has_readout()) j(column++) = m.row_fraction * j.head<6>().dot(image.velocity_per_s);
    for (int k = 0; k < imaging.num_intrinsics(); ++k) {
      j(column++) = m.normal.dot(by_intrinsic(imaging, k, x)) / m.sigma_px;
    }
    const double weight = m.weight * cauchy_weight(r * r, loss_scale);
    term.h.noalias() += (weight * j.transpose()).lazyProduct(j);
    term.g += weight * r * j.transpose();
    term.cost += m.weight * cauchy_cost(r * r, loss_scale);
    direction_errors.add(m, x, rotation, weight);
  }
  direction_errors.discount(&term.h, &term.g, &term.cost);
  return term;
}

void add_intensity_matches(const std::vector<IntensityMatch>& matches, const ImageState& image, double loss_scale,
                           EvidenceTerm* term) {
  const Imaging& imaging = *image.imaging;
  const ImagePose pose = image.pose();
  SpotRows j(2, 6 + imaging.num_parameters());
  for (const IntensityMatch& m : matches) {
    const double fraction = row_fraction(m.pixel.y(), imaging.camera().height());
    const Eigen::Vector3d x = pose.at(fraction) * m.x_in_map;
    const auto seen = project_perturbed(imaging.camera(), x);
    if (!seen) continue;
    const Eigen::Vector2d r = seen->pixel - m.pixel;
    j.leftCols<6>() = seen->by_perturbation;
    Eigen::Index column = 6;
    if (imaging.has_readout()) j.col(column++) = fraction * seen->by_perturbation * image.velocity_per_s;
    for (int k = 0; k < imaging.num_intrinsics(); ++k) {
      j.col(column++) = by_intrinsic(imaging, k, x);
    }
    const double squared = r.dot(m.information * r);
    const Eigen::Matrix2d w = m.weight * cauchy_weight(squared, loss_scale) * m.information;
    term->h.noalias() += j.transpose().lazyProduct((w * j).eval());
    term->g.noalias() += j.transpose().lazyProduct((w * r).eval());
    term->cost += m.weight * cauchy_cost(squared, loss_scale);
  }
}

EvidenceTerm patch_term(const SharedPatches& patches, const ImageState& a, const ImageState& b,
                        const std::optional<double>& range_scale, const PatchNoise& noise) {
  const int parameters_of_a = a.imaging->num_parameters();
  const int size = 12 + parameters_of_a + b.imaging->num_parameters() + (range_scale ? 1 : 0);
  const double scale = range_scale.value_or(0.0);
  EvidenceTerm term(size);
  PatchRows j(2, size);
  for (size_t k = 0; k < patches.matches.size(); ++k) {
    const SurfaceMatch& match = *patches.matches[k];
    const auto r = surface_match_residual(match, a.imaging->camera(), a.pose(), b.imaging->camera(), b.pose(), scale);
    if (!r) continue;
    const Eigen::Vector2d by_range = match.range_sigma_m * r->by_range;
    const Eigen::Matrix2d information =
        (noise.variance_px2 * Eigen::Matrix2d::Identity() + by_range * by_range.transpose()).inverse();
    const double squared = r->residual.dot(information * r->residual);
    const Eigen::Matrix2d w = patches.weights[k] * cauchy_weight(squared, noise.loss_scale) * information;
    j.leftCols<6>() = r->by_a;
    j.middleCols<6>(6) = r->by_b;
    add_imaging_derivatives(match, *r, a, b, scale, 0, 12, &j);
    add_imaging_derivatives(match, *r, a, b, scale, 1, 12 + parameters_of_a, &j);
    if (range_scale) j.col(size - 1) = r->by_range_scale;
    term.h.noalias() += j.transpose().lazyProduct((w * j).eval());
    term.g.noalias() += j.transpose().lazyProduct((w * r->residual).eval());
    term.cost += patches.weights[k] * cauchy_cost(squared, noise.loss_scale);
  }
  return term;
}

}  // namespace cpplus
