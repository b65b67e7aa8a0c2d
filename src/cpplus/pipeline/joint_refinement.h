#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "cpplus/geometry/sparse_model.h"
#include "cpplus/pipeline/grouped_features.h"
#include "cpplus/pipeline/image_sequences.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

struct JointRefinementInput {
  const SparseModel& model;  // coarse poses
  ImageSequences sequences;  // the images that take part
  /// Velocity of each image's coarse pose in its own frame (rad/s, m/s); nothing where it is not known.
  std::vector<std::optional<Vector6d>> velocities_per_s;
  std::function<GrayImage(size_t image)> decode;
};

/// The joint solve over what the images found on their own (`reports`): poses of images that found nothing, or
/// something else than the others expect, by the others. In the order of the model; images without a part keep their
/// coarse pose.
JointResult predict_poses(const JointRefinementInput& input, const std::vector<ImageReport>& reports,
                          const RefineImagesOptions& options);

/// The joint solve over the edges of all images and patches that they share, from the given poses. Replaces the figures
/// and the verdict in the reports of images that take part and are neither blurred nor unreadable.
JointResult refine_jointly(GroupedFeatures* features, const JointRefinementInput& input,
                           const std::vector<Rigid3>& start_camera_from_map, const RefineImagesOptions& options,
                           std::vector<ImageReport>* reports);

}  // namespace cpplus
