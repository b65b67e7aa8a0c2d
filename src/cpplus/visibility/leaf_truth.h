#pragma once

#include <cstdint>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/image.h"
#include "cpplus/geometry/camera.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

enum class LeafTruth : uint8_t {
  kNotJudged,  // outside the image, or too far
  kHidden,     // the true surface is elsewhere along its ray: hidden, in front of it (a moving object), or in the air
  kVisible,    // the true surface agrees within one leaf diagonal
};

/// Where true depth is known: pixel of cell (0, 0) of the range image and the step between cells, pixels.
struct DepthSampling {
  double first_px = 1.5;
  double step_px = 4.0;
};

/// What is known of each leaf of the map from the true depth of an image (range along the ray, metres, 0 = nothing
/// there). A leaf is judged at the mean of its points, within max_distance_m and inside the image. Between the four
/// samples around its pixel 1/range is interpolated, which is exact on planes; across a depth step, where
/// no value between them means anything, the leaf may agree with any of the four.
std::vector<LeafTruth> judge_leaves(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                    const RangeImage& true_range, const DepthSampling& sampling, double max_distance_m);

/// Counts over leaves, summed over images where wanted.
struct VisibilityScore {
  size_t num_visible = 0;       // truly
  size_t num_kept = 0;          // of the judged leaves
  size_t num_kept_visible = 0;  // truly visible leaves that were kept

  double recall() const { return static_cast<double>(num_kept_visible) / static_cast<double>(num_visible); }
  double precision() const { return static_cast<double>(num_kept_visible) / static_cast<double>(num_kept); }
  void add(const std::vector<LeafTruth>& truth, const std::vector<uint32_t>& kept_leaves);
};

}  // namespace cpplus
