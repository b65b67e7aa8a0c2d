#include "cpplus/visibility/range_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "cpplus/geometry/tangent_box.h"
#include "cpplus/visibility/hidden_ranges.h"

namespace cpplus {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();
// Half edge of the square that a point covers, in spacings: gaps twice as wide are closed. Points at random leave
// hardly any larger ones.
constexpr float kHalfSquareSpacings = 1.0f;
constexpr int kMaxHalfCells = 12;
constexpr size_t kUsualPoints = 1 << 20;  // of a view

int half_cells(float spacing_px, float cell_px) {
  const int half = static_cast<int>(kHalfSquareSpacings * spacing_px / cell_px + 0.5f);
  return std::clamp(half, 1, kMaxHalfCells);
}

// Range and spacing of a point in one number: the nearer point has the smaller one, since floats above zero are ordered
// as their bits are.
using Surfel = uint64_t;
constexpr Surfel kNothing = std::numeric_limits<Surfel>::max();

Surfel surfel_of(const ProjectedPoint& point) {
  return Surfel{std::bit_cast<uint32_t>(point.range)} << 32 | std::bit_cast<uint32_t>(point.spacing_px);
}
float range_of(Surfel surfel) { return std::bit_cast<float>(static_cast<uint32_t>(surfel >> 32)); }
float spacing_of(Surfel surfel) { return std::bit_cast<float>(static_cast<uint32_t>(surfel)); }

// Spreads each surfel over its square, the nearest winning.
Image<Surfel> dilate(const Image<Surfel>& in, float cell_px) {
  Image<Surfel> out = in;
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      const Surfel surfel = in.at(x, y);
      if (surfel == kNothing) continue;
      const int half = half_cells(spacing_of(surfel), cell_px);
      const int first = std::max(0, x - half);
      const int last = std::min(in.width - 1, x + half);
      for (int v = std::max(0, y - half); v <= std::min(in.height - 1, y + half); ++v) {
        Surfel* row = &out.at(0, v);
        for (int u = first; u <= last; ++u) row[u] = std::min(row[u], surfel);
      }
    }
  }
  return out;
}

Image<uint8_t> transpose(const Image<uint8_t>& in) {
  Image<uint8_t> out(in.height, in.width);
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) out.at(y, x) = in.at(x, y);
  }
  return out;
}

// The largest range within the square's width of the surfel that won a cell, as a column. `half` is half that width in
// cells, 0 where no surfel did.
RangeImage erode_rows(const Image<uint8_t>& half, const RangeImage& in) {
  RangeImage transposed(in.height, in.width, kNoSurface);
  for (int y = 0; y < in.height; ++y) {
    const float* from = &in.at(0, y);
    const uint8_t* half_of = &half.at(0, y);
    for (int x = 0; x < in.width; ++x) {
      if (half_of[x] == 0) continue;
      const int last = std::min(in.width - 1, x + half_of[x]);
      float farthest = 0.0f;
      for (int u = std::max(0, x - half_of[x]); u <= last; ++u) farthest = std::max(farthest, from[u]);
      transposed.at(y, x) = farthest;
    }
  }
  return transposed;
}

// The points of some leaves in the camera's frame, waiting for their projection.
class PointProjector {
 public:
  PointProjector(const VoxelMap& map, const std::vector<float>& leaf_spacing, const PlaneBuffer& planes,
                 double max_distance_m, std::vector<ProjectedPoint>* points)
      : map_(map),
        leaf_spacing_(leaf_spacing),
        camera_(planes.camera),
        rotation_(planes.camera_from_map.rotation.toRotationMatrix().cast<float>()),
        // float32 holds 40 m to micrometres: the large offsets cancel in double first.
        center_from_origin_((camera_center(planes.camera_from_map) - map.origin()).cast<float>()),
        box_(tangent_box(planes.camera)),
        hidden_(planes),
        min_cos_(static_cast<float>(std::cos(planes.camera.max_view_angle()))),
        max_range_(static_cast<float>(max_distance_m)),
        leaf_diagonal_(static_cast<float>(std::sqrt(3.0) * map.options().leaf_size_m)),
        points_(*points) {}

  void add_leaves(uint32_t leaf, uint32_t end) {
    for (; leaf < end; ++leaf) {
      if (!std::isfinite(leaf_spacing_[leaf])) continue;
      add_points(map_.points_begin(map_.leaf_layer(), leaf), map_.points_end(map_.leaf_layer(), leaf),
                 leaf_spacing_[leaf]);
    }
    project();
  }

 private:
  void add_points(uint32_t i, uint32_t end, float spacing) {
    const Eigen::Vector3f first = in_camera(i);
    const float range_of_first = first.norm();
    if (box_.excludes(first, leaf_diagonal_) || range_of_first > max_range_ + leaf_diagonal_) return;
    if (hidden_.hides(first, range_of_first)) return;
    for (; i < end; ++i) {
      const Eigen::Vector3f x = in_camera(i);
      const float squared_range = x.squaredNorm();
      if (!(squared_range <= max_range_ * max_range_ && squared_range > 1e-6f) || box_.excludes(x)) continue;
      const float range = std::sqrt(squared_range);
      if (x.z() < min_cos_ * range) continue;
      x_in_camera_.push_back(x);
      ranges_.push_back({range, spacing});
    }
  }

  Eigen::Vector3f in_camera(uint32_t i) const { return rotation_ * (map_.positions()[i] - center_from_origin_); }

  void project() {
    camera_.project(x_in_camera_, &pixels_);
    const float pixels_per_radian = static_cast<float>(camera_.pixels_per_radian());
    const Eigen::Array2f last(static_cast<float>(camera_.width()) - 0.5f, static_cast<float>(camera_.height()) - 0.5f);
    for (size_t k = 0; k < pixels_.size(); ++k) {
      const Eigen::Vector2f& pixel = pixels_[k];
      if (!(pixel.x() >= -0.5f && pixel.y() >= -0.5f && pixel.x() < last.x() && pixel.y() < last.y())) continue;
      points_.push_back({pixel, ranges_[k].range, ranges_[k].spacing / ranges_[k].range * pixels_per_radian});
    }
    x_in_camera_.clear();
    ranges_.clear();
  }

  struct Range {
    float range;
    float spacing;
  };

  const VoxelMap& map_;
  const std::vector<float>& leaf_spacing_;
  const Camera& camera_;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f center_from_origin_;
  TangentBox box_;
  HiddenRanges hidden_;
  float min_cos_;
  float max_range_;
  float leaf_diagonal_;
  std::vector<ProjectedPoint>& points_;
  std::vector<Eigen::Vector3f> x_in_camera_;
  std::vector<Range> ranges_;
  std::vector<Eigen::Vector2f> pixels_;
};

}  // namespace

std::vector<ProjectedPoint> project_points(const VoxelMap& map, const std::vector<float>& leaf_spacing,
                                           const PlaneBuffer& planes, double max_distance_m) {
  std::vector<ProjectedPoint> points;
  if (map.num_layers() == 0) return points;
  points.reserve(std::min(map.num_points() / 4, kUsualPoints));
  PointProjector projector(map, leaf_spacing, planes, max_distance_m, &points);
  const Rigid3& camera_from_map = planes.camera_from_map;
  const Eigen::Vector3d axis = camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  for (const uint32_t root :
       map.roots_in_frustum(camera_center(camera_from_map), axis, planes.camera.max_view_angle(), max_distance_m)) {
    uint32_t leaf = root;
    uint32_t end = root + 1;
    for (int layer = 0; layer < map.leaf_layer(); ++layer) {
      leaf = map.children_begin(layer, leaf);
      end = map.children_begin(layer, end);
    }
    projector.add_leaves(leaf, end);
  }
  return points;
}

RangeRaster draw_range_raster(const std::vector<ProjectedPoint>& points, const Camera& camera, double cell_px) {
  RangeRaster raster;
  raster.cell_px = cell_px;
  const int width = static_cast<int>(std::ceil(camera.width() / cell_px));
  const int height = static_cast<int>(std::ceil(camera.height() / cell_px));
  const float cell = static_cast<float>(cell_px);

  Image<Surfel> surfels(width, height, kNothing);  // the nearest point of each cell
  for (const ProjectedPoint& point : points) {
    const Eigen::Vector2i at = raster.cell_of(point.pixel);
    if (!surfels.contains(at.x(), at.y())) continue;
    surfels.at(at.x(), at.y()) = std::min(surfels.at(at.x(), at.y()), surfel_of(point));
  }
  surfels = dilate(surfels, cell);

  RangeImage dilated(width, height, kNoSurface);
  Image<uint8_t> half(width, height, 0);
  raster.spacing_px = RangeImage(width, height, 0.0f);
  for (size_t i = 0; i < surfels.pixels.size(); ++i) {
    const Surfel surfel = surfels.pixels[i];
    if (surfel == kNothing) continue;
    dilated.pixels[i] = range_of(surfel);
    raster.spacing_px.pixels[i] = spacing_of(surfel);
    half.pixels[i] = static_cast<uint8_t>(half_cells(spacing_of(surfel), cell));
  }
  // The squares' borders are taken away again, one axis after the other.
  raster.range = erode_rows(transpose(half), erode_rows(half, dilated));
  for (float& range : raster.range.pixels) {
    if (range == kNoSurface) range = 0.0f;
  }
  return raster;
}

void add_mean_ranges(const std::vector<ProjectedPoint>& points, double depth_m, RangeRaster* raster) {
  const int width = raster->range.width;
  const int height = raster->range.height;
  raster->mean_range = RangeImage(width, height, 0.0f);
  raster->num_points = Image<uint16_t>(width, height, 0);
  const float depth = static_cast<float>(depth_m);
  for (const ProjectedPoint& point : points) {
    const Eigen::Vector2i at = raster->cell_of(point.pixel);
    const float nearest = raster->range_at(at);
    if (nearest <= 0.0f || point.range > nearest + depth) continue;
    uint16_t& count = raster->num_points.at(at.x(), at.y());
    if (count == std::numeric_limits<uint16_t>::max()) continue;
    float& mean = raster->mean_range.at(at.x(), at.y());
    mean += (point.range - mean) / static_cast<float>(++count);
  }
}

}  // namespace cpplus
