#include "cpplus/visibility/range_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cpplus {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();
// Half edge of the square that a point covers, in spacings: gaps twice as wide are closed. Points at random leave
// hardly any larger ones.
constexpr float kHalfSquareSpacings = 1.0f;
constexpr int kMaxHalfCells = 12;

int half_cells(float spacing_px, float cell_px) {
  const int half = static_cast<int>(kHalfSquareSpacings * spacing_px / cell_px + 0.5f);
  return std::clamp(half, 1, kMaxHalfCells);
}

// The nearest point of each cell.
RangeRaster draw_points(const std::vector<ProjectedPoint>& points, const Camera& camera, double cell_px) {
  RangeRaster raster;
  raster.cell_px = cell_px;
  const int width = static_cast<int>(std::ceil(camera.width() / cell_px));
  const int height = static_cast<int>(std::ceil(camera.height() / cell_px));
  raster.range = RangeImage(width, height, kNoSurface);
  raster.spacing_px = RangeImage(width, height, 0.0f);
  for (const ProjectedPoint& point : points) {
    const Eigen::Vector2i cell = raster.cell_of(point.pixel);
    if (!raster.range.contains(cell.x(), cell.y()) || point.range >= raster.range.at(cell.x(), cell.y())) continue;
    raster.range.at(cell.x(), cell.y()) = point.range;
    raster.spacing_px.at(cell.x(), cell.y()) = point.spacing_px;
  }
  return raster;
}

// Each cell's point covers a square; the nearest wins.
RangeRaster dilate(const RangeRaster& points) {
  RangeRaster out = points;
  const int width = points.range.width;
  const int height = points.range.height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float range = points.range.at(x, y);
      if (range == kNoSurface) continue;
      const float spacing = points.spacing_px.at(x, y);
      const int half = half_cells(spacing, static_cast<float>(points.cell_px));
      for (int v = std::max(0, y - half); v <= std::min(height - 1, y + half); ++v) {
        for (int u = std::max(0, x - half); u <= std::min(width - 1, x + half); ++u) {
          if (range >= out.range.at(u, v)) continue;
          out.range.at(u, v) = range;
          out.spacing_px.at(u, v) = spacing;
        }
      }
    }
  }
  return out;
}

// The largest range within the square of the point that won a cell, one axis after the other.
void erode(RangeRaster* raster) {
  const int width = raster->range.width;
  const int height = raster->range.height;
  const auto half_at = [&](int x, int y) {
    return half_cells(raster->spacing_px.at(x, y), static_cast<float>(raster->cell_px));
  };
  RangeImage columns(height, width, kNoSurface);  // transposed
  for (int y = 0; y < height; ++y) {
    const float* row = &raster->range.at(0, y);
    for (int x = 0; x < width; ++x) {
      if (row[x] == kNoSurface) continue;
      const int half = half_at(x, y);
      columns.at(y, x) = *std::max_element(row + std::max(0, x - half), row + std::min(width - 1, x + half) + 1);
    }
  }
  for (int x = 0; x < width; ++x) {
    const float* column = &columns.at(0, x);
    for (int y = 0; y < height; ++y) {
      float farthest = kNoSurface;
      if (column[y] != kNoSurface) {
        const int half = half_at(x, y);
        farthest = *std::max_element(column + std::max(0, y - half), column + std::min(height - 1, y + half) + 1);
      }
      raster->range.at(x, y) = farthest == kNoSurface ? 0.0f : farthest;
    }
  }
}

}  // namespace

std::vector<ProjectedPoint> project_points(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                           const Camera& camera, const Rigid3& camera_from_map, double max_distance_m) {
  std::vector<ProjectedPoint> points;
  if (map.num_layers() == 0) return points;
  const Eigen::Matrix3f rotation = camera_from_map.rotation.toRotationMatrix().cast<float>();
  // float32 holds 40 m to micrometres: the large offsets cancel in double first.
  const Eigen::Vector3d center = camera_center(camera_from_map);
  const Eigen::Vector3f center_from_origin = (center - map.origin()).cast<float>();
  const Eigen::Vector3d axis = camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const float min_cos = static_cast<float>(std::cos(camera.max_view_angle()));
  const float max_range = static_cast<float>(max_distance_m);
  const float pixels_per_radian = static_cast<float>(camera.pixels_per_radian());
  for (const uint32_t root : map.roots_in_frustum(center, axis, camera.max_view_angle(), max_distance_m)) {
    uint32_t leaf = root;
    uint32_t end = root + 1;
    for (int layer = 0; layer < map.leaf_layer(); ++layer) {
      leaf = map.children_begin(layer, leaf);
      end = map.children_begin(layer, end);
    }
    for (; leaf < end; ++leaf) {
      const float spacing = leaf_spacing[leaf];
      if (!std::isfinite(spacing)) continue;
      for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
        const Eigen::Vector3f x = rotation * (map.positions()[i] - center_from_origin);
        const float range = x.norm();
        if (range > max_range || x.z() < min_cos * range || range < 1e-3f) continue;
        const auto pixel = camera.project(x.cast<double>());
        if (!pixel || !camera.in_image(*pixel, -0.5)) continue;
        points.push_back({pixel->cast<float>(), range, spacing / range * pixels_per_radian});
      }
    }
  }
  return points;
}

RangeRaster draw_range_raster(const std::vector<ProjectedPoint>& points, const Camera& camera, double cell_px) {
  RangeRaster raster = dilate(draw_points(points, camera, cell_px));
  erode(&raster);
  return raster;
}

}  // namespace cpplus
