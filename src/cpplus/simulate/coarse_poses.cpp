#include "cpplus/simulate/coarse_poses.h"

#include <algorithm>
#include <cmath>

#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr double kRadToDeg = 180.0 / M_PI;

Vector3d random_unit(Random& random) {
  return Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

double rms_rotation_deg(const std::vector<Rigid3>& truth, const std::vector<Rigid3>& estimate) {
  double sum = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) sum += std::pow(rotation_angle_between(truth[i], estimate[i]), 2);
  return kRadToDeg * std::sqrt(sum / static_cast<double>(truth.size()));
}

double rms_translation_m(const std::vector<Rigid3>& truth, const std::vector<Rigid3>& estimate) {
  double sum = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) {
    sum += (camera_center(truth[i]) - camera_center(estimate[i])).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

std::vector<Rigid3> poses_at(const std::function<Rigid3(double)>& pose_at, const std::vector<double>& stamps,
                             double offset_s) {
  std::vector<Rigid3> poses;
  for (const double stamp : stamps) poses.push_back(pose_at(stamp + offset_s));
  return poses;
}

/// Unscaled perturbations in the camera frame: extrinsic, drift and noise of each image.
std::vector<Vector6d> perturbations(const std::vector<Rigid3>& poses, const std::vector<double>& stamps,
                                    const CoarseOptions& options) {
  Random random(hash_seed(options.seed, 0xC0));
  const SmoothNoise drift(hash_seed(options.seed, 0xD1), options.shortest_drift_period_s,
                          options.longest_drift_period_s);
  Vector6d extrinsic;
  extrinsic << random_unit(random), random_unit(random);
  std::vector<Vector6d> result;
  for (size_t i = 0; i < poses.size(); ++i) {
    const Vector6d drift_in_map = drift.at(stamps[i]) / std::sqrt(3.0);
    Vector6d delta = options.extrinsic_share * extrinsic;
    delta.head<3>() += options.drift_share * (poses[i].rotation * Vector3d(drift_in_map.head<3>()));
    delta.tail<3>() += options.drift_share * (poses[i].rotation * Vector3d(drift_in_map.tail<3>()));
    for (int k = 0; k < 6; ++k) delta[k] += options.noise_share * random.normal() / std::sqrt(3.0);
    result.push_back(delta);
  }
  return result;
}

std::vector<Rigid3> perturbed(const std::vector<Rigid3>& poses, const std::vector<Vector6d>& deltas, double rotation,
                              double translation) {
  std::vector<Rigid3> result;
  for (size_t i = 0; i < poses.size(); ++i) {
    Vector6d delta;
    delta << rotation * deltas[i].head<3>(), translation * deltas[i].tail<3>();
    result.push_back(perturb_camera(poses[i], delta));
  }
  return result;
}

/// Smallest non-negative x with f(x) = target, for f that starts below and ends above.
double solve_scale(const std::function<double(double)>& f, double target, double upper) {
  double low = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + upper);
    (f(middle) < target ? low : upper) = middle;
  }
  return 0.5 * (low + upper);
}

}  // namespace

SmoothNoise::SmoothNoise(uint64_t seed, double shortest_period_s, double longest_period_s) {
  Random random(seed);
  for (int k = 0; k < 6; ++k) {
    for (int wave = 0; wave < kWaves; ++wave) {
      phase_rad_(k, wave) = random.uniform(0.0, 2.0 * M_PI);
      // One period from each part of the range: two that are nearly equal would beat for a long time.
      const double share = (wave + random.uniform(0.2, 0.8)) / kWaves;
      rate_(k, wave) = 2.0 * M_PI / (shortest_period_s * std::pow(longest_period_s / shortest_period_s, share));
    }
  }
}

Vector6d SmoothNoise::at(double time_s) const {
  return std::sqrt(2.0 / kWaves) * (phase_rad_ + time_s * rate_).array().sin().rowwise().sum().matrix();
}

CoarsePoses make_coarse_poses(const std::function<Rigid3(double)>& camera_from_map_at,
                              const std::vector<double>& stamps_s, const CoarseOptions& options) {
  const std::vector<Rigid3> truth = poses_at(camera_from_map_at, stamps_s, 0.0);
  CoarsePoses result;
  result.name = options.name;
  result.time_offset_s = options.time_offset_s;
  std::vector<Rigid3> shifted = poses_at(camera_from_map_at, stamps_s, result.time_offset_s);
  while (rms_rotation_deg(truth, shifted) > 0.5 * options.rms_rotation_deg ||
         rms_translation_m(truth, shifted) > 0.5 * options.rms_translation_m) {
    result.time_offset_s *= 0.8;
    shifted = poses_at(camera_from_map_at, stamps_s, result.time_offset_s);
  }
  const std::vector<Vector6d> deltas = perturbations(shifted, stamps_s, options);
  const double rotation =
      solve_scale([&](double scale) { return rms_rotation_deg(truth, perturbed(shifted, deltas, scale, 0.0)); },
                  options.rms_rotation_deg, 4.0 * options.rms_rotation_deg / kRadToDeg);
  const double translation =
      solve_scale([&](double scale) { return rms_translation_m(truth, perturbed(shifted, deltas, 0.0, scale)); },
                  options.rms_translation_m, 4.0 * options.rms_translation_m);
  result.camera_from_map = perturbed(shifted, deltas, rotation, translation);
  result.rms_rotation_deg = rms_rotation_deg(truth, result.camera_from_map);
  result.rms_translation_m = rms_translation_m(truth, result.camera_from_map);
  return result;
}

std::vector<CoarseOptions> standard_coarse_levels(uint64_t seed) {
  std::vector<CoarseOptions> levels(3);
  const std::vector<std::string> names = {"small", "medium", "large"};
  const std::vector<double> rotations_deg = {0.3, 0.8, 2.0};
  const std::vector<double> translations_m = {0.03, 0.08, 0.2};
  for (size_t i = 0; i < 3; ++i) {
    Random random(hash_seed(seed, 0x1E, i));
    levels[i].name = names[i];
    levels[i].rms_rotation_deg = rotations_deg[i];
    levels[i].rms_translation_m = translations_m[i];
    levels[i].time_offset_s = (random.uniform() < 0.5 ? -1.0 : 1.0) * random.uniform(0.014, 0.03);
    levels[i].seed = random.next();
  }
  return levels;
}

}  // namespace cpplus
