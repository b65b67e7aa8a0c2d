#include "cpplus/simulate/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;

constexpr int kRangeStep = 4;
constexpr double kRangeOffset = 1.5;  // pixel (4 i + 2, 4 j + 2) where the corner of the image is (0, 0)
constexpr double kMovingShare = 5e-4;

}  // namespace

Camera simulated_camera(const SimulateOptions& options) {
  const auto model = camera_model_from_name(options.camera);
  const double width = options.width;
  const double height = options.height;
  const double focal = 0.652 * width;
  // Off the middle, as principal points are.
  const double cx = 0.5 * width - 0.5 + 0.0032 * width;
  const double cy = 0.5 * height - 0.5 - 0.006 * height;
  switch (*model) {
    case CameraModel::kPinhole:
      return Camera(*model, options.width, options.height, {focal, focal, cx, cy});
    case CameraModel::kOpenCv:
      return Camera(*model, options.width, options.height, {focal, focal, cx, cy, -0.105, 0.032, 0.0007, -0.0005});
    case CameraModel::kOpenCvFisheye: {
      const double fisheye_focal = width / M_PI;  // 180 degrees across the width
      return Camera(*model, options.width, options.height,
                    {fisheye_focal, fisheye_focal, cx, cy, 0.012, -0.006, 0.001, -0.0002});
    }
    default:
      return Camera(*model, options.width, options.height, {width, height});
  }
}

Rigid3 simulated_extrinsic(uint64_t seed) {
  Random random(hash_seed(seed, 0xE7));
  Eigen::Matrix3d lidar_from_camera;
  lidar_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Vector3d turn(random.uniform(-0.05, 0.05), random.uniform(-0.03, 0.03), random.uniform(-0.015, 0.015));
  return Rigid3(Eigen::Matrix3d(lidar_from_camera * so3_exp(turn)),
                Vector3d(random.uniform(0.05, 0.1), random.uniform(-0.03, 0.03), random.uniform(-0.13, -0.08)));
}

std::vector<double> spread_stamps(int count, double duration_s, double jitter, uint64_t seed) {
  Random random(seed);
  std::vector<double> stamps;
  for (int i = 0; i < count; ++i) {
    const double share = (i + 0.5 + jitter * random.uniform(-0.5, 0.5)) / count;
    stamps.push_back(duration_s * (0.03 + 0.94 * share));
  }
  return stamps;
}

std::vector<Shot> plan_shots(double duration_s, const SimulateOptions& options) {
  const auto seed = static_cast<uint64_t>(options.seed);
  std::vector<Shot> shots;
  for (const double stamp : spread_stamps(options.images, duration_s, 0.3, hash_seed(seed, 0x1A))) {
    Shot shot;
    shot.stamp_s = stamp;
    shot.seed = hash_seed(seed, 0x1B, shots.size());
    shots.push_back(shot);
  }
  Random random(hash_seed(seed, 0x1C));
  for (int i = 0; i < options.blurred; ++i) {
    const int index = std::min(options.images - 1,
                               static_cast<int>((i + random.uniform(0.3, 0.7)) * options.images / options.blurred));
    Shot& shot = shots[static_cast<size_t>(index)];
    shot.blur_px = options.width / 1024.0 * random.uniform(13.0, 24.0);
    shot.blur_direction_rad = random.uniform(-0.8, 0.8);
  }
  return shots;
}

SimulatedImage take_image(const Renderer& renderer, const Shot& shot, size_t index) {
  SimulatedImage image;
  image.name = fmt::format("{:06d}.jpg", index);
  image.stamp_s = shot.stamp_s;
  image.camera_from_map = renderer.camera_from_map(shot.stamp_s);
  image.pixels = renderer.render(shot);
  image.range = renderer.range(shot, kRangeStep, kRangeOffset);
  image.blur_px = shot.blur_px;
  image.blur_direction_rad = shot.blur_direction_rad;
  image.shows_moving = renderer.moving_share(shot, 8) > kMovingShare;
  return image;
}

std::vector<double> stamps_of(const std::vector<SimulatedImage>& images) {
  std::vector<double> stamps;
  for (const SimulatedImage& image : images) stamps.push_back(image.stamp_s);
  return stamps;
}

StatedPoses::StatedPoses(const SimulateOptions& options)
    : noise_(hash_seed(static_cast<uint64_t>(options.seed), 0x71), 4.0, 25.0),
      rotation_rad_(options.scan_pose_sigma_deg * M_PI / 180.0),
      translation_m_(options.scan_pose_sigma_m),
      scale_(options.standing ? 0.4 : 1.0) {}

Rigid3 StatedPoses::at(double stamp_s, const Rigid3& true_map_from_lidar) const {
  const Vector6d noise = scale_ * noise_.at(stamp_s);
  Rigid3 stated = true_map_from_lidar;
  stated.rotation = stated.rotation * Eigen::Quaterniond(so3_exp(rotation_rad_ * noise.head<3>()));
  stated.translation += translation_m_ * noise.tail<3>();
  return stated;
}

std::vector<CoarsePoses> coarse_levels(const Path& path, const Rigid3& lidar_from_camera,
                                       const std::vector<double>& stamps_s, uint64_t seed) {
  const auto camera_at = [&](double time_s) { return inverse(path.map_from_lidar(time_s) * lidar_from_camera); };
  std::vector<CoarsePoses> levels;
  for (const CoarseOptions& level : standard_coarse_levels(seed)) {
    levels.push_back(make_coarse_poses(camera_at, stamps_s, level));
  }
  return levels;
}

}  // namespace cpplus
