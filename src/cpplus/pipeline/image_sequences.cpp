#include "cpplus/pipeline/image_sequences.h"

#include <algorithm>

#include "cpplus/pipeline/camera_velocity.h"

namespace cpplus {
namespace {

Trajectory coarse_trajectory(const SparseModel& model, const std::vector<std::pair<double, size_t>>& sequence) {
  Trajectory trajectory;
  for (const auto& [time, i] : sequence) {
    if (!trajectory.empty() && time <= trajectory.back().stamp_s) continue;
    trajectory.push_back({time, inverse(model.images[i].camera_from_map)});
  }
  return trajectory;
}

}  // namespace

ImageSequences image_sequences(const SparseModel& model, const std::map<std::string, double>& stamps) {
  ImageSequences sequences;
  for (size_t i = 0; i < model.images.size(); ++i) {
    const auto stamp = stamps.find(model.images[i].name);
    if (!stamps.empty() && stamp == stamps.end()) continue;
    const double time = stamps.empty() ? static_cast<double>(i) : stamp->second;
    sequences[model.images[i].camera_id].emplace_back(time, i);
  }
  for (auto& [camera, sequence] : sequences) std::sort(sequence.begin(), sequence.end());
  return sequences;
}

std::vector<std::optional<Vector6d>> image_velocities(const SparseModel& model, const ImageSequences& sequences,
                                                      bool stamped, const Trajectory& trajectory) {
  std::vector<std::optional<Vector6d>> velocities(model.images.size());
  if (!stamped) return velocities;
  for (const auto& [camera, sequence] : sequences) {
    const TrajectorySpline way(trajectory.empty() ? coarse_trajectory(model, sequence) : trajectory);
    for (const auto& [time, i] : sequence) {
      velocities[i] = camera_velocity(way, time, model.images[i].camera_from_map);
    }
  }
  return velocities;
}

}  // namespace cpplus
