#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace cpplus {

/// Points of a plane in square cells, for neighbour look-ups. Cells keep the order of the points.
class Grid2d {
 public:
  Grid2d(const std::vector<Eigen::Vector2d>& points, double cell_size) : cell_size_(cell_size) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
    Eigen::Vector2d high = -low;
    for (const Eigen::Vector2d& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    origin_ = low;
    width_ = points.empty() ? 1 : 1 + static_cast<int>((high.x() - low.x()) / cell_size);
    height_ = points.empty() ? 1 : 1 + static_cast<int>((high.y() - low.y()) / cell_size);
    begin_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_) + 1, 0);
    for (const Eigen::Vector2d& p : points) ++begin_[cell_of(p) + 1];
    for (size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    items_.resize(points.size());
    std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (uint32_t i = 0; i < points.size(); ++i) items_[next[cell_of(points[i])]++] = i;
  }

  /// Calls visit(index) for every point in the cells that touch the square of half-width `radius` around x.
  template <typename Visit>
  void for_each_near(const Eigen::Vector2d& x, double radius, Visit&& visit) const {
    const int x0 = std::max(0, column(x.x() - radius));
    const int x1 = std::min(width_ - 1, column(x.x() + radius));
    const int y0 = std::max(0, row(x.y() - radius));
    const int y1 = std::min(height_ - 1, row(x.y() + radius));
    for (int cy = y0; cy <= y1; ++cy) {
      for (int cx = x0; cx <= x1; ++cx) {
        const size_t cell = static_cast<size_t>(cy) * static_cast<size_t>(width_) + static_cast<size_t>(cx);
        for (uint32_t k = begin_[cell]; k < begin_[cell + 1]; ++k) visit(items_[k]);
      }
    }
  }

 private:
  int column(double x) const { return static_cast<int>(std::floor((x - origin_.x()) / cell_size_)); }
  int row(double y) const { return static_cast<int>(std::floor((y - origin_.y()) / cell_size_)); }
  size_t cell_of(const Eigen::Vector2d& p) const {
    return static_cast<size_t>(row(p.y())) * static_cast<size_t>(width_) + static_cast<size_t>(column(p.x()));
  }

  double cell_size_;
  Eigen::Vector2d origin_;
  int width_ = 1;
  int height_ = 1;
  std::vector<uint32_t> begin_;
  std::vector<uint32_t> items_;
};

}  // namespace cpplus
