#include "cpplus/visibility/leaf_truth.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cpplus {
namespace {

/// Ranges at the corners of the sampling cell around a pixel and the pixel's place in it.
struct Corners {
  std::array<double, 4> ranges;  // top left, top right, bottom left, bottom right
  double right = 0.0;
  double down = 0.0;
};

Corners corners_at(const RangeImage& image, const Eigen::Vector2d& pixel, const DepthSampling& sampling) {
  const double x = std::clamp((pixel.x() - sampling.first_px) / sampling.step_px, 0.0, image.width - 1.0);
  const double y = std::clamp((pixel.y() - sampling.first_px) / sampling.step_px, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(image.width - 2, 0));
  const int y0 = std::min(static_cast<int>(y), std::max(image.height - 2, 0));
  const int x1 = std::min(x0 + 1, image.width - 1);
  const int y1 = std::min(y0 + 1, image.height - 1);
  return {{image.at(x0, y0), image.at(x1, y0), image.at(x0, y1), image.at(x1, y1)}, x - x0, y - y0};
}

bool agrees(const Corners& corners, double range, double tolerance_m) {
  constexpr double kStepRatio = 1.3;
  const auto [nearest, farthest] = std::minmax_element(corners.ranges.begin(), corners.ranges.end());
  const auto close_to = [&](double r) { return r > 0.0 && std::abs(r - range) <= tolerance_m; };
  if (*nearest <= 0.0 || *farthest > kStepRatio * *nearest)
    return std::any_of(corners.ranges.begin(), corners.ranges.end(), close_to);
  const auto& [r00, r10, r01, r11] = corners.ranges;
  const double inverse = (1.0 - corners.down) * ((1.0 - corners.right) / r00 + corners.right / r10) +
                         corners.down * ((1.0 - corners.right) / r01 + corners.right / r11);
  return close_to(1.0 / inverse);
}

}  // namespace

std::vector<LeafTruth> judge_leaves(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                    const RangeImage& true_range, const DepthSampling& sampling,
                                    double max_distance_m) {
  const int layer = map.leaf_layer();
  const double diagonal = map.options().leaf_size_m * std::sqrt(3.0);
  std::vector<LeafTruth> truth(map.num_nodes(layer), LeafTruth::kNotJudged);
  for (uint32_t leaf = 0; leaf < truth.size(); ++leaf) {
    const Eigen::Vector3d x_in_camera = camera_from_map * map.statistics(layer, leaf).mean;
    const double range = x_in_camera.norm();
    if (range > max_distance_m) continue;
    const auto pixel = camera.project(x_in_camera);
    if (!pixel || !camera.in_image(*pixel, -0.5)) continue;
    const bool visible = agrees(corners_at(true_range, *pixel, sampling), range, diagonal);
    truth[leaf] = visible ? LeafTruth::kVisible : LeafTruth::kHidden;
  }
  return truth;
}

void VisibilityScore::add(const std::vector<LeafTruth>& truth, const std::vector<uint32_t>& kept_leaves) {
  num_visible += static_cast<size_t>(std::count(truth.begin(), truth.end(), LeafTruth::kVisible));
  for (const uint32_t leaf : kept_leaves) {
    num_kept += truth[leaf] != LeafTruth::kNotJudged;
    num_kept_visible += truth[leaf] == LeafTruth::kVisible;
  }
}

}  // namespace cpplus
