#include "cpplus/report/top_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/error.h"

namespace cpplus {
namespace {

// So many leaves above one another make a pixel half opaque.
constexpr double kHalfOpaqueLeaves = 8.0;
constexpr uint8_t kGray = 120;

cv::Mat count_leaves(const VoxelMap& map, const TopView& view, const TopViewBounds& bounds, double pixel_m,
                     const cv::Size& size) {
  cv::Mat counts = cv::Mat::zeros(size, CV_32FC1);
  const double margin = map.voxel_size(0);  // a root reaches less far from its middle
  for (uint32_t root = 0; root < map.num_nodes(0); ++root) {
    const Eigen::Array2d middle = view * map.center(0, root);
    if ((middle < bounds.min.array() - margin || middle > bounds.max.array() + margin).any()) continue;
    const NodeRange leaves = leaves_of(map, 0, root);
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      const Eigen::Vector2d p = (view * map.center(map.leaf_layer(), leaf) - bounds.min) / pixel_m;
      const int column = static_cast<int>(std::floor(p.x()));
      const int row = size.height - 1 - static_cast<int>(std::floor(p.y()));
      if (column >= 0 && row >= 0 && column < size.width && row < size.height) counts.at<float>(row, column) += 1.0f;
    }
  }
  return counts;
}

}  // namespace

Eigen::Vector3d up_axis(const std::vector<Rigid3>& cameras_from_map) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3& camera_from_map : cameras_from_map) {
    sum -= camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitY();  // y points down in a camera
  }
  if (sum.norm() < 1e-9) return Eigen::Vector3d::UnitZ();
  Eigen::Index axis = 2;
  sum.cwiseAbs().maxCoeff(&axis);
  return Eigen::Vector3d::Unit(axis) * (sum[axis] > 0 ? 1.0 : -1.0);
}

TopView::TopView(const Eigen::Vector3d& up) {
  right = std::abs(up.x()) > 0.5 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  ahead = up.cross(right);
}

TopViewBounds bounds_around(const std::vector<Eigen::Vector2d>& positions, double margin_m) {
  TopViewBounds bounds;
  if (positions.empty()) return bounds;
  bounds.min = bounds.max = positions.front();
  for (const Eigen::Vector2d& p : positions) {
    bounds.min = bounds.min.cwiseMin(p);
    bounds.max = bounds.max.cwiseMax(p);
  }
  const double margin = std::max(margin_m, 0.5 * (bounds.max - bounds.min).maxCoeff());
  bounds.min.array() -= margin;
  bounds.max.array() += margin;
  return bounds;
}

std::vector<uint8_t> floor_plan_png(const VoxelMap& map, const TopView& view, const TopViewBounds& bounds,
                                    int max_side_px) {
  const Eigen::Vector2d extent = bounds.max - bounds.min;
  const double pixel_m = std::max(extent.maxCoeff() / max_side_px, map.voxel_size(map.leaf_layer()));
  const cv::Size size(std::max(1, static_cast<int>(std::lround(extent.x() / pixel_m))),
                      std::max(1, static_cast<int>(std::lround(extent.y() / pixel_m))));
  const cv::Mat counts = count_leaves(map, view, bounds, pixel_m, size);
  cv::Mat picture(size, CV_8UC4);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double opacity = 1.0 - std::exp2(-counts.at<float>(row, column) / kHalfOpaqueLeaves);
      picture.at<cv::Vec4b>(row, column) = {kGray, kGray, kGray, static_cast<uint8_t>(std::lround(255.0 * opacity))};
    }
  }
  std::vector<uint8_t> bytes;
  if (!cv::imencode(".png", picture, bytes)) throw Error("cannot encode the floor plan as PNG");
  return bytes;
}

}  // namespace cpplus
