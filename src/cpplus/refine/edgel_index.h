#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "cpplus/geometry/image_edge.h"

namespace cpplus {

/// Finds image edges near a projected map edge that run in the same direction.
class EdgelIndex {
 public:
  explicit EdgelIndex(const ImageEdges& edges);

  /// The edgel nearest to `pixel` along the line through it in direction `normal` (unit), within radius_px, whose own
  /// normal differs from it by at most acos(min_cos). Its index in ImageEdges::edgels; nothing if there is none.
  std::optional<uint32_t> nearest_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double radius_px,
                                        double min_cos) const;

  /// All such edgels within radius_px of the pixel, each once, in the order in which they are come upon.
  void all_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double radius_px, double min_cos,
                 std::vector<uint32_t>* found) const;

  const ImageEdgel& edgel(uint32_t index) const { return edges_.edgels[index]; }

 private:
  // Index of the edgel at the pixel nearest to p, if its normal agrees; -1 otherwise.
  int32_t agreeing_edgel(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, double min_cos) const;

  const ImageEdges& edges_;
  std::vector<int32_t> edgel_at_;  // per pixel; -1 = none
};

/// Truncated distances to the nearest edgel of about the same direction, one field for each of kBins directions, on a
/// grid of cell_px pixels: answers "how well does this sample fit here" in one look-up.
class DirectionalDistanceField {
 public:
  static constexpr int kBins = 8;

  DirectionalDistanceField(const ImageEdges& edges, int cell_px, double max_distance_px);

  /// Distance in pixels, at most max_distance_px; that much outside the image.
  float distance(const Eigen::Vector2f& pixel, int bin) const {
    const int x = static_cast<int>((pixel.x() + 0.5f) * inverse_cell_);
    const int y = static_cast<int>((pixel.y() + 0.5f) * inverse_cell_);
    if (pixel.x() < -0.5f || pixel.y() < -0.5f || x >= width_ || y >= height_) return max_distance_;
    return fields_[static_cast<size_t>(bin)]
                  [static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
  }

  /// The bin of an edge whose normal in the image is (x, y); opposite normals share a bin.
  static int bin_of(const Eigen::Vector2d& normal);

  float max_distance() const { return max_distance_; }

 private:
  int width_ = 0;
  int height_ = 0;
  float inverse_cell_ = 1.0f;
  float max_distance_ = 0.0f;
  std::array<std::vector<float>, kBins> fields_;
};

}  // namespace cpplus
