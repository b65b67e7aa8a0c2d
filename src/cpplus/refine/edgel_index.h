#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "cpplus/geometry/image_edge.h"

namespace cpplus {

/// Finds image edges near a projected map edge that run in the same direction: those whose normals differ by at most
/// max_angle_deg, (0, 90).
class EdgelIndex {
 public:
  /// `edges` must outlive this.
  EdgelIndex(const ImageEdges& edges, double max_angle_deg);

  /// The edgel nearest to `pixel` along the line through it in direction `normal` (unit), within radius_px, that runs
  /// in the same direction. Its index in ImageEdges::edgels; nothing if there is none.
  std::optional<uint32_t> nearest_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
                                        double radius_px) const;

  /// All such edgels within radius_px of the pixel, each once, in the order in which they are come upon.
  void all_along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double radius_px,
                 std::vector<uint32_t>* found) const;

  const ImageEdgel& edgel(uint32_t index) const { return edges_.edgels[index]; }

 private:
  size_t index_of(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(edges_.width) + static_cast<size_t>(x);
  }
  bool is_inside(const Eigen::Vector2d& pixel, double margin_px) const {
    return pixel.x() >= margin_px && pixel.y() >= margin_px && pixel.x() < edges_.width - 1 - margin_px &&
           pixel.y() < edges_.height - 1 - margin_px;
  }
  bool is_occupied(size_t pixel) const { return occupied_[pixel / 64] >> (pixel % 64) & 1; }
  // Of the edgel of an occupied pixel in by_pixel_.
  size_t place_of(size_t pixel) const {
    const uint64_t before = occupied_[pixel / 64] & ((uint64_t{1} << (pixel % 64)) - 1);
    return num_before_[pixel / 64] + static_cast<size_t>(std::popcount(before));
  }
  // Bit of the eighth of half a turn that a normal points to, the same for the opposite one.
  static uint8_t direction_of(const Eigen::Vector2d& normal);

  // Calls visit(index) for the edgels whose normal agrees at the three pixels abreast around a place.
  template <typename Visit>
  void for_each_abreast(const Eigen::Vector2d& place, const Eigen::Vector2d& normal, uint8_t direction,
                        const Visit& visit) const;

  const ImageEdges& edges_;
  double min_cos_;
  // Edgels in the order of their pixels, found by counting the bits of occupied pixels: small enough for the cache.
  std::vector<uint64_t> occupied_;    // a bit a pixel
  std::vector<uint32_t> num_before_;  // of the bits in earlier words
  std::vector<uint32_t> by_pixel_;
  // Per pixel the directions that edgels there and at its eight neighbours agree with: in most places it says at once
  // that there is nothing to be found.
  std::vector<uint8_t> directions_near_;
};

/// Truncated distances to the nearest edgel of about the same direction, one field for each of kBins directions, on a
/// grid of cell_px pixels: answers "how well does this sample fit here" in one look-up.
class DirectionalDistanceField {
 public:
  static constexpr int kBins = 8;

  DirectionalDistanceField(const ImageEdges& edges, int cell_px, double max_distance_px);

  /// Distance in pixels, at most max_distance_px; that much outside the image.
  float distance(const Eigen::Vector2f& pixel, int bin) const {
    return distance_at(index_of(pixel.x(), pixel.y(), bin));
  }

  /// distance() in two steps, for loops over many pixels: the arithmetic of the first becomes vector instructions.
  int32_t index_of(float x, float y, int32_t bin) const {
    const float column = std::min(std::max(0.0f, (x + 0.5f) * inverse_cell_ + 1.0f), last_column_);
    const float row = std::min(std::max(0.0f, (y + 0.5f) * inverse_cell_ + 1.0f), last_row_);
    return (static_cast<int32_t>(row) * stride_ + static_cast<int32_t>(column)) * kBins + bin;
  }
  float distance_at(int32_t index) const { return to_pixels(units_at(index)); }
  /// The second step in two again, of which the latter becomes vector instructions too.
  int32_t units_at(int32_t index) const { return field_[static_cast<size_t>(index)]; }
  float to_pixels(int32_t units) const { return unit_px_ * static_cast<float>(units); }

  /// The bin of an edge whose normal in the image is (x, y); opposite normals share a bin.
  static int bin_of(const Eigen::Vector2d& normal);

  float max_distance() const { return max_distance_; }

 private:
  using Distances = std::array<int16_t, kBins>;

  int16_t* cell(int column, int row) { return &field_[static_cast<size_t>((row * stride_ + column) * kBins)]; }
  // Two passes of the chamfer distance transform, all directions at once.
  void spread(int16_t straight, int16_t diagonal);

  int stride_ = 0;  // cells a row: those of the image within a frame of cells that are far from all
  int rows_ = 0;
  float inverse_cell_ = 1.0f;
  float last_column_ = 0.0f;
  float last_row_ = 0.0f;
  float max_distance_ = 0.0f;
  float unit_px_ = 1.0f;
  std::vector<int16_t> field_;  // by row, column, bin; in units of unit_px_
};

}  // namespace cpplus
