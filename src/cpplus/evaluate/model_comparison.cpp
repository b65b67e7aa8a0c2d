#include "cpplus/evaluate/model_comparison.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "cpplus/core/error.h"

namespace cpplus {
namespace {

using ImagesByName = std::map<std::string, const PosedImage*>;

ImagesByName images_by_name(const SparseModel& model, const std::set<std::string>& excluded) {
  ImagesByName images;
  for (const PosedImage& image : model.images) {
    if (excluded.count(image.name)) continue;
    if (!images.emplace(image.name, &image).second) {
      throw Error(fmt::format("image name {} occurs twice in one model", image.name));
    }
  }
  return images;
}

const Camera& camera_of(const SparseModel& model, const PosedImage& image) {
  const auto camera = model.cameras.find(image.camera_id);
  if (camera == model.cameras.end()) {
    throw Error(fmt::format("image {}: camera {} is not in the model", image.name, image.camera_id));
  }
  return camera->second;
}

void summarize_images(ModelComparison* comparison) {
  std::vector<double> rotations_deg, translations_m, shifts_px, residuals_px;
  for (const ImageComparison& image : comparison->images) {
    rotations_deg.push_back(image.pose.rotation_deg);
    translations_m.push_back(image.pose.translation_m);
    if (image.shift.num_points > 0) shifts_px.push_back(image.shift.mean_px);
    if (!std::isnan(image.checkerboard_px)) residuals_px.push_back(image.checkerboard_px);
  }
  comparison->rotation_deg = sample_statistics(std::move(rotations_deg));
  comparison->translation_m = sample_statistics(std::move(translations_m));
  comparison->shift_shares = success_shares(shifts_px);
  comparison->shift_px = sample_statistics(std::move(shifts_px));
  comparison->checkerboard_px = sample_statistics(std::move(residuals_px));
}

void compare_trajectories(const std::vector<Rigid3>& estimate, const std::vector<Rigid3>& reference,
                          ModelComparison* comparison) {
  for (const auto alignment : {TrajectoryAlignment::kNone, TrajectoryAlignment::kPositionYaw, TrajectoryAlignment::kSe3,
                               TrajectoryAlignment::kSim3}) {
    const auto transform = align_trajectory(estimate, reference, alignment);
    comparison->absolute.push_back({alignment, {}});
    if (transform) comparison->absolute.back().error = absolute_trajectory_error(estimate, reference, *transform);
  }
  comparison->relative.push_back(
      {0.0, relative_pose_error(estimate, reference, pose_pairs_by_step(reference.size(), 1))});
  double path_m = 0.0;
  for (size_t i = 1; i < reference.size(); ++i) {
    path_m += (reference[i].translation - reference[i - 1].translation).norm();
  }
  if (path_m <= 0.0) return;
  for (const double share : {0.1, 0.25, 0.5}) {
    const PosePairs pairs = pose_pairs_by_length(reference, share * path_m);
    comparison->relative.push_back({share * path_m, relative_pose_error(estimate, reference, pairs)});
  }
}

}  // namespace

ModelComparison compare_models(const SparseModel& estimate, const SparseModel& reference,
                               const VisiblePointsOfImage& visible_points, const std::vector<Checkerboard>& boards,
                               const std::set<std::string>& excluded) {
  const ImagesByName estimate_images = images_by_name(estimate, excluded);
  const ImagesByName reference_images = images_by_name(reference, excluded);

  ModelComparison comparison;
  std::vector<Rigid3> estimate_map_from_camera, reference_map_from_camera;
  for (const auto& [name, reference_image] : reference_images) {
    const auto match = estimate_images.find(name);
    if (match == estimate_images.end()) {
      comparison.only_in_reference.push_back(name);
      continue;
    }
    const Camera& camera = camera_of(reference, *reference_image);
    const Rigid3& truth = reference_image->camera_from_map;
    const Rigid3& guess = match->second->camera_from_map;
    comparison.images.push_back({name, pose_error(guess, truth),
                                 reprojection_shift(visible_points(*reference_image, camera), camera, guess, truth),
                                 checkerboard_residual_px(boards, name, camera, guess)});
    estimate_map_from_camera.push_back(inverse(guess));
    reference_map_from_camera.push_back(inverse(truth));
  }
  for (const auto& [name, image] : estimate_images) {
    if (!reference_images.count(name)) comparison.only_in_estimate.push_back(name);
  }
  summarize_images(&comparison);
  compare_trajectories(estimate_map_from_camera, reference_map_from_camera, &comparison);
  return comparison;
}

}  // namespace cpplus
