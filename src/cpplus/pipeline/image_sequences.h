#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cpplus/geometry/rigid3.h"
#include "cpplus/geometry/sparse_model.h"
#include "cpplus/geometry/trajectory.h"

namespace cpplus {

/// Images of each camera in order of time: (time, index in the model). Each camera of a rig has errors of its own, so
/// each makes a sequence of its own.
using ImageSequences = std::map<uint32_t, std::vector<std::pair<double, size_t>>>;

/// With stamps (seconds, by image name) the images that have one; without any the place in the model counts as time.
ImageSequences image_sequences(const SparseModel& model, const std::map<std::string, double>& stamps);

/// Velocity of each image's coarse pose in its own frame (rad/s, m/s), in the order of the model: from the trajectory
/// (map_from_sensor), or from the coarse poses where that is empty. Nothing where `stamped` is false or an instant is
/// outside the trajectory.
std::vector<std::optional<Vector6d>> image_velocities(const SparseModel& model, const ImageSequences& sequences,
                                                      bool stamped, const Trajectory& trajectory);

}  // namespace cpplus
