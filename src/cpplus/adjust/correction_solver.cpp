#include "cpplus/adjust/correction_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cpplus/adjust/pose_equations.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr size_t kGrain = 64;
constexpr double kDegree = M_PI / 180.0;

Vector6d information_of(double sigma_m, double sigma_deg) {
  Vector6d information;
  information << Vector3d::Constant(1.0 / (sigma_deg * kDegree * sigma_deg * kDegree)),
      Vector3d::Constant(1.0 / (sigma_m * sigma_m));
  return information;
}

void add_priors(const SolveOptions& options, const ScanPoses& poses, PoseEquations* equations) {
  const Vector6d weak = information_of(options.prior_sigma_m, options.prior_sigma_deg);
  const Vector6d smooth = information_of(options.smooth_sigma_m, options.smooth_sigma_deg);
  Vector6d previous = Vector6d::Zero();
  for (size_t i = 0; i < poses.current.size(); ++i) {
    const Vector6d correction = pose_correction(poses.input[i], poses.current[i]);
    equations->add_prior(i, correction, weak);
    if (i > 0) equations->add_smoothness(i - 1, correction - previous, smooth);
    previous = correction;
  }
}

double median(std::vector<double>* values) {
  if (values->empty()) return 0.0;
  const auto middle = values->begin() + static_cast<ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

/// Patches at the present poses, with weights that leave out what does not lie on the plane.
class PatchWeighter {
 public:
  PatchWeighter(const std::vector<ScanPatch>& patches, const SolveOptions& options)
      : patches_(patches), range_variance_(std::pow(range_noise(patches), 2)), options_(options) {}

  std::vector<WeightedPatch> weigh(const std::vector<Rigid3>& base, const std::vector<Rigid3>& current) const {
    std::vector<Rigid3> motions;
    for (size_t i = 0; i < base.size(); ++i) motions.push_back(current[i] * inverse(base[i]));
    std::vector<WeightedPatch> weighted(patches_.size());
    for_patches(&weighted, [&](size_t p, WeightedPatch* patch) {
      for (const ScanCluster& cluster : patches_[p].clusters) {
        patch->clusters.push_back(moved(cluster, motions[cluster.scan]));
        patch->weights.push_back(information(cluster));
      }
      patch->plane = fit_patch_plane(patch->clusters, patch->weights);
    });
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      const double scale = std::max(offset_scale(weighted), options_.plane_sigma_m);
      for_patches(&weighted, [&](size_t, WeightedPatch* patch) { reweigh(scale, patch); });
    }
    return weighted;
  }

 private:
  template <typename Body>
  static void for_patches(std::vector<WeightedPatch>* patches, const Body& body) {
    parallel_for_chunks(patches->size(), kGrain, [&](size_t begin, size_t end) {
      for (size_t p = begin; p < end; ++p) body(p, &(*patches)[p]);
    });
  }

  double mean_variance(const ScanCluster& cluster) const { return range_variance_ / cluster.count; }
  double information(const ScanCluster& cluster) const {
    return 1.0 / (mean_variance(cluster) + options_.plane_sigma_m * options_.plane_sigma_m);
  }

  /// Robust standard deviation of the clusters' distances from their planes.
  static double offset_scale(const std::vector<WeightedPatch>& patches) {
    std::vector<double> offsets;
    for (const WeightedPatch& patch : patches) {
      for (const ScanCluster& cluster : patch.clusters)
        offsets.push_back(std::abs(patch.plane.normal.dot(cluster.mean - patch.plane.mean)));
    }
    return 1.4826 * median(&offsets);
  }

  /// Cauchy's weight for the distance of the mean, Tukey's for the spread about the plane: a thick cluster is a
  /// body's or an edge's, whichever plane runs through it.
  void reweigh(double scale, WeightedPatch* patch) const {
    constexpr double kCauchy = 2.0;
    constexpr double kThick = 3.0;
    for (size_t k = 0; k < patch->clusters.size(); ++k) {
      const ScanCluster& cluster = patch->clusters[k];
      const Vector3d& normal = patch->plane.normal;
      const double offset = normal.dot(cluster.mean - patch->plane.mean);
      const double variance = mean_variance(cluster) + scale * scale;
      const double spread = normal.dot(cluster.covariance * normal);
      const double thick_limit = kThick * kThick * (range_variance_ + options_.plane_sigma_m * options_.plane_sigma_m);
      const double near = 1.0 / (1.0 + offset * offset / (kCauchy * kCauchy * variance));
      const double thin = std::pow(std::max(1.0 - spread / thick_limit, 1e-3), 2);
      patch->weights[k] = near * thin * information(cluster);
    }
    patch->plane = fit_patch_plane(patch->clusters, patch->weights);
  }

  const std::vector<ScanPatch>& patches_;
  double range_variance_;
  const SolveOptions& options_;
};

std::vector<Vector3d> sensors_of(const std::vector<Rigid3>& map_from_lidar) {
  std::vector<Vector3d> sensors;
  for (const Rigid3& pose : map_from_lidar) sensors.push_back(pose.translation);
  return sensors;
}

/// How much further the clusters' means are from the planes than their weights say, squared; at least one.
double misfit(const std::vector<WeightedPatch>& patches) {
  double sum = 0.0;
  double redundancy = 0.0;
  for (const WeightedPatch& patch : patches) {
    for (size_t k = 0; k < patch.clusters.size(); ++k) {
      const double offset = patch.plane.normal.dot(patch.clusters[k].mean - patch.plane.mean);
      sum += patch.weights[k] * offset * offset;
    }
    redundancy += static_cast<double>(patch.clusters.size()) - 3.0;
  }
  return redundancy > 0.0 ? std::max(1.0, sum / redundancy) : 1.0;
}

/// Takes the common rigid motion out of the covariance of all corrections: P C P' with the projection P onto what is
/// orthogonal to turns about the sensors' centre and to shifts.
Eigen::MatrixXd without_common_motion(const Eigen::MatrixXd& covariance, const std::vector<Vector3d>& sensors) {
  Vector3d center = Vector3d::Zero();
  for (const Vector3d& sensor : sensors) center += sensor / static_cast<double>(sensors.size());
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(covariance.rows(), 6);
  for (size_t i = 0; i < sensors.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    motion.block<6, 6>(row, 0).setIdentity();
    for (int axis = 0; axis < 3; ++axis)
      motion.block<3, 1>(row + 3, axis) = Vector3d::Unit(axis).cross(sensors[i] - center);
  }
  const Eigen::MatrixXd solved = (motion.transpose() * motion).ldlt().solve(motion.transpose());  // 6 x N
  const Eigen::MatrixXd left = covariance - motion * (solved * covariance);
  return left - (left * solved.transpose()) * motion.transpose();
}

Eigen::MatrixXd inverse_of(const PoseEquations& equations) {
  const Eigen::MatrixXd matrix = equations.dense();
  return matrix.llt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

}  // namespace

void SolveOptions::validate() const {
  const auto check = [](const char* name, double value) {
    check_option(value > 0.0 && std::isfinite(value), name, "(0, inf)", value);
  };
  check("plane_sigma_m", plane_sigma_m);
  check("prior_sigma_m", prior_sigma_m);
  check("prior_sigma_deg", prior_sigma_deg);
  check("smooth_sigma_m", smooth_sigma_m);
  check("smooth_sigma_deg", smooth_sigma_deg);
}

Vector6d pose_correction(const Rigid3& from_map_from_lidar, const Rigid3& to_map_from_lidar) {
  Vector6d correction;
  correction << so3_log(to_map_from_lidar.rotation * from_map_from_lidar.rotation.conjugate()),
      to_map_from_lidar.translation - from_map_from_lidar.translation;
  return correction;
}

CorrectionStep solve_corrections(const std::vector<ScanPatch>& patches, const SolveOptions& options, ScanPoses* poses) {
  constexpr int kSteps = 3;
  const PatchWeighter weighter(patches, options);
  const std::vector<Rigid3> base = poses->current;
  for (int step = 0; step < kSteps; ++step) {
    PoseEquations equations(base.size());
    add_patches(weighter.weigh(base, poses->current), sensors_of(poses->current), &equations);
    add_priors(options, *poses, &equations);
    const Eigen::VectorXd solution = equations.solve();
    for (size_t i = 0; i < base.size(); ++i) {
      const Vector6d correction = solution.segment<6>(static_cast<Eigen::Index>(6 * i));
      const Eigen::Quaterniond turn(so3_exp(correction.head<3>()));
      Rigid3& pose = poses->current[i];
      pose = Rigid3(turn * pose.rotation, pose.translation + correction.tail<3>());
    }
  }
  CorrectionStep whole;
  for (size_t i = 0; i < base.size(); ++i) {
    const Vector6d way = pose_correction(base[i], poses->current[i]);
    whole.largest_rad = std::max(whole.largest_rad, way.head<3>().norm());
    whole.largest_m = std::max(whole.largest_m, way.tail<3>().norm());
  }
  return whole;
}

CorrectionCovariance correction_covariance(const std::vector<ScanPatch>& patches, const SolveOptions& options,
                                           const ScanPoses& poses) {
  const std::vector<Vector3d> sensors = sensors_of(poses.current);
  PoseEquations priors(sensors.size());
  add_priors(options, poses, &priors);
  PoseEquations all = priors;
  std::vector<WeightedPatch> weighted = PatchWeighter(patches, options).weigh(poses.current, poses.current);
  const double too_far = misfit(weighted);
  for (WeightedPatch& patch : weighted) {
    for (double& weight : patch.weights) weight /= too_far;
  }
  add_patches(weighted, sensors, &all);
  return {without_common_motion(inverse_of(all), sensors), without_common_motion(inverse_of(priors), sensors)};
}

}  // namespace cpplus
