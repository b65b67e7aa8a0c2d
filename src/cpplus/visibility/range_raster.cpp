#include "cpplus/visibility/range_raster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "cpplus/cloud/node_range.h"
#include "cpplus/core/vector_clones.h"
#include "cpplus/geometry/tangent_box.h"
#include "cpplus/visibility/hidden_ranges.h"
#include "cpplus/visibility/range_keys.h"

namespace cpplus {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();
// Half edge of the square that a point covers, in spacings: gaps twice as wide are closed. Points at random leave
// hardly any larger ones.
constexpr float kHalfSquareSpacings = 1.0f;
constexpr int kMaxHalfCells = 12;
constexpr size_t kUsualPoints = 1 << 20;  // of a view

int half_cells(float spacing_px, float inverse_cell) {
  const int half = static_cast<int>(kHalfSquareSpacings * spacing_px * inverse_cell + 0.5f);
  return std::clamp(half, 1, kMaxHalfCells);
}

RangeKey key_of(const ProjectedPoint& point) {
  return range_key(point.range, std::bit_cast<uint32_t>(point.spacing_px));
}
float spacing_of(RangeKey key) { return std::bit_cast<float>(what_of(key)); }

// Spreads each point over its square, the nearest winning. Squares grow by one cell a step, the larger ones from an
// earlier step on; the few very large ones are drawn one by one.
Image<RangeKey> dilate(const Image<RangeKey>& in, float inverse_cell) {
  constexpr int kMostSteps = 4;
  std::array<std::vector<size_t>, kMostSteps + 1> cells_of_half;
  Image<RangeKey> large(in.width, in.height, kNoRangeKey);
  size_t cell = 0;
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x, ++cell) {
      if (in.pixels[cell] == kNoRangeKey) continue;
      const int half = half_cells(spacing_of(in.pixels[cell]), inverse_cell);
      if (half <= kMostSteps) {
        cells_of_half[static_cast<size_t>(half)].push_back(cell);
      } else {
        draw_rectangle(std::max(0, x - half), std::min(in.width - 1, x + half), y - half, y + half, in.pixels[cell],
                       &large);
      }
    }
  }
  Image<RangeKey> out(in.width, in.height, kNoRangeKey);
  for (size_t half = kMostSteps; half > 0; --half) {
    for (const size_t c : cells_of_half[half]) out.pixels[c] = std::min(out.pixels[c], in.pixels[c]);
    spread_by_one(&out);
  }
  take_nearer(large, &out);
  return out;
}

Image<uint8_t> transpose(const Image<uint8_t>& in) {
  Image<uint8_t> out(in.height, in.width);
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) out.at(y, x) = in.at(x, y);
  }
  return out;
}

// Largest values of windows of one row, each in two look-ups: tables hold those of windows of 1, 2, 4, 8 and 16 cells.
class RowMaxima {
 public:
  explicit RowMaxima(int width) {
    for (std::vector<float>& table : tables_) table.assign(static_cast<size_t>(width), 0.0f);
  }

  void set(const float* row) {
    std::copy_n(row, tables_[0].size(), tables_[0].begin());
    for (size_t k = 1; k < tables_.size(); ++k) {
      const size_t half = size_t{1} << (k - 1);
      if (tables_[0].size() < 2 * half) break;
      larger_of_two(tables_[k - 1].data(), half, tables_[0].size() - 2 * half + 1, tables_[k].data());
    }
  }

  // Of the cells first ... last, at most 2 * kMaxHalfCells + 1.
  float largest(int first, int last) const {
    const auto k = static_cast<size_t>(std::bit_width(static_cast<uint32_t>(last - first + 1)) - 1);
    return std::max(tables_[k][static_cast<size_t>(first)], tables_[k][static_cast<size_t>(last + 1 - (1 << k))]);
  }

 private:
  CPPLUS_VECTOR_CLONES static void larger_of_two(const float* in, size_t apart, size_t count, float* out) {
    for (size_t i = 0; i < count; ++i) out[i] = in[i] < in[i + apart] ? in[i + apart] : in[i];
  }

  std::array<std::vector<float>, 5> tables_;
};
static_assert(2 * kMaxHalfCells + 1 < 32);

// The largest range within the square's width of the point that won a cell, as a column. `half` is half that width in
// cells, 0 where no point did.
RangeImage erode_rows(const Image<uint8_t>& half, const RangeImage& in) {
  RangeImage transposed(in.height, in.width, kNoSurface);
  RowMaxima maxima(in.width);
  for (int y = 0; y < in.height; ++y) {
    maxima.set(&in.at(0, y));
    const uint8_t* half_of = &half.at(0, y);
    for (int x = 0; x < in.width; ++x) {
      if (half_of[x] == 0) continue;
      transposed.at(y, x) = maxima.largest(std::max(0, x - half_of[x]), std::min(in.width - 1, x + half_of[x]));
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

  void add_leaves(const NodeRange& leaves) {
    for (const uint32_t seen : leaves_in_view(leaves)) {
      add_points(map_.points_begin(map_.leaf_layer(), seen), map_.points_end(map_.leaf_layer(), seen),
                 leaf_spacing_[seen]);
    }
    project();
  }

 private:
  // Those that the image may show, told by their first points.
  const std::vector<uint32_t>& leaves_in_view(const NodeRange& leaves) {
    leaves_.clear();
    x_in_camera_.clear();
    for (uint32_t leaf = leaves.begin; leaf < leaves.end; ++leaf) {
      if (!std::isfinite(leaf_spacing_[leaf])) continue;
      const Eigen::Vector3f first = in_camera(map_.points_begin(map_.leaf_layer(), leaf));
      if (box_.excludes(first, leaf_diagonal_) || first.norm() > max_range_ + leaf_diagonal_) continue;
      leaves_.push_back(leaf);
      x_in_camera_.push_back(first);
    }
    camera_.project(x_in_camera_, &pixels_);
    size_t kept = 0;
    for (size_t k = 0; k < leaves_.size(); ++k) {
      if (!hidden_.hides(pixels_[k], x_in_camera_[k].norm())) leaves_[kept++] = leaves_[k];
    }
    leaves_.resize(kept);
    x_in_camera_.clear();
    return leaves_;
  }

  void add_points(uint32_t i, uint32_t end, float spacing) {
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
  std::vector<uint32_t> leaves_;
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
    projector.add_leaves(leaves_of(map, 0, root));
  }
  return points;
}

RangeRaster draw_range_raster(const std::vector<ProjectedPoint>& points, const Camera& camera, double cell_px) {
  RangeRaster raster;
  raster.cell_px = cell_px;
  const int width = static_cast<int>(std::ceil(camera.width() / cell_px));
  const int height = static_cast<int>(std::ceil(camera.height() / cell_px));
  const float inverse_cell = 1.0f / static_cast<float>(cell_px);

  Image<RangeKey> nearest(width, height, kNoRangeKey);  // point of each cell
  for (const ProjectedPoint& point : points) {
    const Eigen::Vector2i at = raster.cell_of(point.pixel);
    if (!nearest.contains(at.x(), at.y())) continue;
    nearest.at(at.x(), at.y()) = std::min(nearest.at(at.x(), at.y()), key_of(point));
  }
  nearest = dilate(nearest, inverse_cell);

  RangeImage dilated(width, height, kNoSurface);
  Image<uint8_t> half(width, height, 0);
  raster.spacing_px = RangeImage(width, height, 0.0f);
  for (size_t i = 0; i < nearest.pixels.size(); ++i) {
    const RangeKey key = nearest.pixels[i];
    if (key == kNoRangeKey) continue;
    dilated.pixels[i] = range_of(key);
    raster.spacing_px.pixels[i] = spacing_of(key);
    half.pixels[i] = static_cast<uint8_t>(half_cells(spacing_of(key), inverse_cell));
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
