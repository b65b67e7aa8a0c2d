#include "cpplus/evaluate/trajectory_error.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <cmath>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

/// Below this ratio of the singular values of the covariance the positions count as lying on a line.
constexpr double kMinSpreadRatio = 1e-12;

void check_sizes(const std::vector<Rigid3>& estimate, const std::vector<Rigid3>& reference) {
  if (estimate.size() != reference.size()) {
    throw Error(fmt::format("trajectories to compare must be equally long, got {} and {} poses", estimate.size(),
                            reference.size()));
  }
}

/// The moments that all the alignments need.
struct Moments {
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d reference_mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // reference times estimate transposed
  double estimate_variance = 0.0;
};

Moments moments_of(const std::vector<Rigid3>& estimate, const std::vector<Rigid3>& reference) {
  Moments m;
  const double n = static_cast<double>(estimate.size());
  for (size_t i = 0; i < estimate.size(); ++i) {
    m.estimate_mean += estimate[i].translation / n;
    m.reference_mean += reference[i].translation / n;
  }
  for (size_t i = 0; i < estimate.size(); ++i) {
    const Eigen::Vector3d x = estimate[i].translation - m.estimate_mean;
    m.covariance += (reference[i].translation - m.reference_mean) * x.transpose() / n;
    m.estimate_variance += x.squaredNorm() / n;
  }
  return m;
}

std::optional<Similarity3> align_position_yaw(const Moments& m) {
  const double sine = m.covariance(1, 0) - m.covariance(0, 1);
  const double cosine = m.covariance(0, 0) + m.covariance(1, 1);
  if (std::hypot(sine, cosine) <= kMinSpreadRatio * m.covariance.norm() || m.covariance.norm() == 0.0) return {};
  Similarity3 transform;
  transform.rotation = Eigen::AngleAxisd(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ());
  return transform;
}

std::optional<Similarity3> align_umeyama(const Moments& m, bool with_scale) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d singular = svd.singularValues();
  if (singular(1) <= kMinSpreadRatio * singular(0) || singular(0) == 0.0) return {};
  // Eq. 39-43, Umeyama 1991: the sign keeps the result a rotation, not a reflection.
  Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1);
  Similarity3 transform;
  transform.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose()));
  if (with_scale) transform.scale = singular.dot(sign) / m.estimate_variance;
  return transform;
}

}  // namespace

const char* trajectory_alignment_name(TrajectoryAlignment alignment) {
  switch (alignment) {
    case TrajectoryAlignment::kNone:
      return "none";
    case TrajectoryAlignment::kPositionYaw:
      return "posyaw";
    case TrajectoryAlignment::kSe3:
      return "se3";
    case TrajectoryAlignment::kSim3:
      return "sim3";
  }
  return "";
}

std::optional<Similarity3> align_trajectory(const std::vector<Rigid3>& estimate_map_from_camera,
                                            const std::vector<Rigid3>& reference_map_from_camera,
                                            TrajectoryAlignment alignment) {
  check_sizes(estimate_map_from_camera, reference_map_from_camera);
  if (estimate_map_from_camera.empty()) return {};
  if (alignment == TrajectoryAlignment::kNone) return Similarity3{};
  const Moments moments = moments_of(estimate_map_from_camera, reference_map_from_camera);
  std::optional<Similarity3> transform = alignment == TrajectoryAlignment::kPositionYaw
                                             ? align_position_yaw(moments)
                                             : align_umeyama(moments, alignment == TrajectoryAlignment::kSim3);
  if (transform) transform->translation = moments.reference_mean - *transform * moments.estimate_mean;
  return transform;
}

TrajectoryError absolute_trajectory_error(const std::vector<Rigid3>& estimate_map_from_camera,
                                          const std::vector<Rigid3>& reference_map_from_camera,
                                          const Similarity3& reference_from_estimate) {
  check_sizes(estimate_map_from_camera, reference_map_from_camera);
  std::vector<double> translations_m;
  std::vector<double> rotations_deg;
  for (size_t i = 0; i < estimate_map_from_camera.size(); ++i) {
    const Rigid3& estimate = estimate_map_from_camera[i];
    const Rigid3 aligned{reference_from_estimate.rotation * estimate.rotation,
                         reference_from_estimate * estimate.translation};
    translations_m.push_back((aligned.translation - reference_map_from_camera[i].translation).norm());
    rotations_deg.push_back(rotation_angle_between(aligned, reference_map_from_camera[i]) * 180.0 / M_PI);
  }
  return {sample_statistics(std::move(translations_m)), sample_statistics(std::move(rotations_deg))};
}

PosePairs pose_pairs_by_step(size_t num_poses, size_t step) {
  PosePairs pairs;
  for (size_t i = 0; i + step < num_poses; ++i) pairs.emplace_back(i, i + step);
  return pairs;
}

PosePairs pose_pairs_by_length(const std::vector<Rigid3>& reference_map_from_camera, double length_m) {
  std::vector<double> path_m(reference_map_from_camera.size(), 0.0);
  for (size_t i = 1; i < path_m.size(); ++i) {
    path_m[i] = path_m[i - 1] +
                (reference_map_from_camera[i].translation - reference_map_from_camera[i - 1].translation).norm();
  }
  PosePairs pairs;
  for (size_t i = 0, j = 0; i < path_m.size(); ++i) {
    j = std::max(j, i + 1);
    while (j < path_m.size() && path_m[j] - path_m[i] < length_m) ++j;
    if (j < path_m.size()) pairs.emplace_back(i, j);
  }
  return pairs;
}

TrajectoryError relative_pose_error(const std::vector<Rigid3>& estimate_map_from_camera,
                                    const std::vector<Rigid3>& reference_map_from_camera, const PosePairs& pairs,
                                    double scale) {
  check_sizes(estimate_map_from_camera, reference_map_from_camera);
  std::vector<double> translations_m;
  std::vector<double> rotations_deg;
  for (const auto& [i, j] : pairs) {
    Rigid3 estimate_i_from_j = inverse(estimate_map_from_camera[i]) * estimate_map_from_camera[j];
    estimate_i_from_j.translation *= scale;
    const Rigid3 reference_i_from_j = inverse(reference_map_from_camera[i]) * reference_map_from_camera[j];
    const Rigid3 error = inverse(reference_i_from_j) * estimate_i_from_j;
    translations_m.push_back(error.translation.norm());
    rotations_deg.push_back(so3_log(error.rotation).norm() * 180.0 / M_PI);
  }
  return {sample_statistics(std::move(translations_m)), sample_statistics(std::move(rotations_deg))};
}

}  // namespace cpplus
