#include "cpplus/adjust/adjust_scans.h"

#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>

#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/core/random.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

/// Some of the points of the scans.
struct Sample {
  ScanSet scans;
  std::vector<uint32_t> scan_of_point;

  void add(const PointCloud& points, size_t i, size_t scan) {
    scans.points.positions.push_back(points.positions[i]);
    scan_of_point.push_back(static_cast<uint32_t>(scan));
  }
};

struct Samples {
  Sample used;
  Sample held_out;
};

/// Deals the points of every scan out by chance: neither sample follows the rings of the LiDAR.
Samples deal_out(const ScanSet& scans, int points_per_scan) {
  Samples samples;
  for (Sample* sample : {&samples.used, &samples.held_out}) {
    sample->scans.points.origin = scans.points.origin;
    sample->scans.sensors_in_map = scans.sensors_in_map;
  }
  for (size_t scan = 0; scan < scans.num_scans(); ++scan) {
    const size_t begin = scans.first_point[scan];
    const size_t end = scans.first_point[scan + 1];
    const double half = 0.5 * std::min(1.0, points_per_scan / static_cast<double>(end - begin));
    Random random(scan + 1);
    for (size_t i = begin; i < end; ++i) {
      const double chance = random.uniform();
      if (chance < half) samples.used.add(scans.points, i, scan);
      if (chance >= half && chance < 2.0 * half) samples.held_out.add(scans.points, i, scan);
    }
    for (Sample* sample : {&samples.used, &samples.held_out})
      sample->scans.first_point.push_back(sample->scans.points.size());
  }
  return samples;
}

std::vector<Rigid3> motions_between(const std::vector<Rigid3>& from, const std::vector<Rigid3>& to) {
  std::vector<Rigid3> motions;
  for (size_t i = 0; i < from.size(); ++i) motions.push_back(to[i] * inverse(from[i]));
  return motions;
}

std::vector<ScanPatch> patches_at(const Sample& sample, const ScanPoses& poses, const PatchOptions& options) {
  ScanSet scans = sample.scans;
  move_scans(poses.input, poses.current, &scans);
  return find_scan_patches(scans.points, sample.scan_of_point, scans.sensors_in_map, options);
}

/// Directions in which the scans add little to the priors.
std::vector<WeakDirection> weak_directions(const Eigen::Matrix3d& posterior, const Eigen::Matrix3d& prior) {
  constexpr double kWeakShare = 0.5;
  std::vector<WeakDirection> weak;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(posterior);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d direction = eigen.eigenvectors().col(axis);
    const double variance = eigen.eigenvalues()[axis];
    if (variance > kWeakShare * kWeakShare * direction.dot(prior * direction))
      weak.push_back({direction, std::sqrt(variance)});
  }
  return weak;
}

std::vector<ScanAdjustment> describe_scans(const std::vector<ScanPatch>& patches, const SolveOptions& options,
                                           const ScanPoses& poses) {
  std::vector<ScanAdjustment> scans(poses.current.size());
  const CorrectionCovariance covariance = correction_covariance(patches, options, poses);
  for (size_t i = 0; i < scans.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    scans[i].correction = pose_correction(poses.input[i], poses.current[i]);
    scans[i].sigma = covariance.posterior.diagonal().segment<6>(row).cwiseMax(0.0).cwiseSqrt();
    scans[i].weak_directions = weak_directions(covariance.posterior.block<3, 3>(row + 3, row + 3),
                                               covariance.prior.block<3, 3>(row + 3, row + 3));
  }
  for (const ScanPatch& patch : patches) {
    for (const ScanCluster& cluster : patch.clusters) ++scans[cluster.scan].num_patches;
  }
  return scans;
}

/// Finds patches and solves in turn, until nothing moves any more. Returns the patches at the end.
std::vector<ScanPatch> iterate(const Sample& sample, const AdjustOptions& options, ScanPoses* poses,
                               AdjustResult* result) {
  constexpr double kStill = 2e-4;         // metres
  constexpr double kStillAngle = 3.5e-5;  // rad: 0.2 mm at 6 m
  Progress progress("adjust", static_cast<size_t>(options.max_iterations));
  std::vector<ScanPatch> patches = patches_at(sample, *poses, options.patches);
  while (result->iterations < options.max_iterations && !result->has_converged) {
    const CorrectionStep step = solve_corrections(patches, options.solve, poses);
    result->has_converged = step.largest_m < kStill && step.largest_rad < kStillAngle;
    ++result->iterations;
    patches = patches_at(sample, *poses, options.patches);
    progress.advance();
  }
  return patches;
}

/// Few planes say nothing about the whole: about ten a scan are needed.
bool has_enough(const std::vector<ScanPatch>& patches, size_t num_scans) {
  constexpr size_t kMinClusters = 10;
  size_t num_clusters = 0;
  for (const ScanPatch& patch : patches) num_clusters += patch.clusters.size();
  return num_clusters >= kMinClusters * num_scans;
}

}  // namespace

void AdjustOptions::validate() const {
  patches.validate();
  solve.validate();
  check_option(points_per_scan >= 100, "points_per_scan", "[100, inf)", points_per_scan);
  check_option(max_iterations >= 1, "max_iterations", "[1, inf)", max_iterations);
  check_option(min_gain >= 0.0 && min_gain < 1.0, "min_gain", "[0, 1)", min_gain);
}

std::string status_name(AdjustStatus status) {
  switch (status) {
    case AdjustStatus::kAdjusted:
      return "adjusted";
    case AdjustStatus::kKeptTooFewScans:
      return "kept_too_few_scans";
    case AdjustStatus::kKeptTooFewPatches:
      return "kept_too_few_patches";
    case AdjustStatus::kKeptNotThinner:
      return "kept_not_thinner";
  }
  assert(false);
  return "";
}

void move_scans(const std::vector<Rigid3>& from_map_from_lidar, const std::vector<Rigid3>& to_map_from_lidar,
                ScanSet* scans) {
  const std::vector<Rigid3> motions = motions_between(from_map_from_lidar, to_map_from_lidar);
  PointCloud& points = scans->points;
  parallel_for_each(motions.size(), [&](size_t scan) {
    const Eigen::Matrix3d rotation = motions[scan].rotation.toRotationMatrix();
    const Vector3d offset = motions[scan] * points.origin - points.origin;
    for (size_t i = scans->first_point[scan]; i < scans->first_point[scan + 1]; ++i)
      points.positions[i] = (rotation * points.positions[i].cast<double>() + offset).cast<float>();
    scans->sensors_in_map[scan] = to_map_from_lidar[scan].translation;
  });
}

AdjustResult adjust_scans(const ScanSet& scans, const std::vector<Rigid3>& map_from_lidar,
                          const AdjustOptions& options) {
  options.validate();
  assert(map_from_lidar.size() == scans.num_scans());
  AdjustResult result;
  result.map_from_lidar = map_from_lidar;
  result.scans.resize(scans.num_scans());
  if (scans.num_scans() < 3) return result;

  ScanPoses poses{map_from_lidar, map_from_lidar};
  const Samples samples = deal_out(scans, options.points_per_scan);
  const std::vector<ScanPatch> held_out = patches_at(samples.held_out, poses, options.patches);
  result.status = AdjustStatus::kKeptTooFewPatches;
  if (!has_enough(held_out, scans.num_scans())) return result;

  const std::vector<ScanPatch> patches = iterate(samples.used, options, &poses, &result);
  result.num_patches = patches.size();
  result.scans = describe_scans(patches, options.solve, poses);
  result.thickness = measure_thickness(held_out, motions_between(poses.input, poses.current));
  constexpr double kSure = 3.0;  // standard deviations
  const ThicknessChange& change = result.thickness;
  const bool is_thinner = change.gain >= options.min_gain && change.gain > kSure * change.gain_sigma;
  result.status = is_thinner ? AdjustStatus::kAdjusted : AdjustStatus::kKeptNotThinner;
  if (is_thinner) result.map_from_lidar = poses.current;
  return result;
}

}  // namespace cpplus
