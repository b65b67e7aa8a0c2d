#include "cpplus/visibility/depth_buffer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "cpplus/cloud/select_roots.h"
#include "cpplus/core/options.h"
#include "cpplus/visibility/extended_surfaces.h"

namespace cpplus {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();
constexpr int kBlockCells = 16;
/// How much larger a square may be at the border of an image than at the principal point.
constexpr double kMaxMagnification = 2.0;
/// Bodies of up to about a metre count as small whatever the leaves are: surroundings are cubes of three such nodes.
constexpr double kNodeSizeM = 0.25;

/// Cells per radian in x and y, the half extents of a ball's projection over its angular radius, sampled on blocks of
/// cells: the magnification of a lens varies slowly over the image, but by far too much to be ignored (threefold at
/// the corners of a wide pinhole image, without bound at the poles of a panorama).
class Magnification {
 public:
  explicit Magnification(const DepthBuffer& buffer)
      : width_((buffer.range.width + kBlockCells - 1) / kBlockCells),
        height_((buffer.range.height + kBlockCells - 1) / kBlockCells) {
    const float central = static_cast<float>(buffer.camera.pixels_per_radian() / buffer.cell_px);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const Eigen::Vector2i cell(x * kBlockCells + kBlockCells / 2, y * kBlockCells + kBlockCells / 2);
        const auto bearing = buffer.camera.unproject(buffer.center_of(cell));
        Eigen::Vector2d pixel;
        Eigen::Matrix<double, 2, 3> jacobian;  // at range 1 m, hence pixels per radian
        const bool valid = bearing && buffer.camera.project(*bearing, &pixel, &jacobian);
        cells_per_radian_.push_back(valid ? (jacobian.rowwise().norm() / buffer.cell_px).cast<float>().eval()
                                          : Eigen::Vector2f::Constant(central));
      }
    }
  }

  const Eigen::Vector2f& at(const Eigen::Vector2i& cell) const {
    return cells_per_radian_[static_cast<size_t>(cell.y() / kBlockCells * width_ + cell.x() / kBlockCells)];
  }

 private:
  int width_;
  int height_;
  std::vector<Eigen::Vector2f> cells_per_radian_;
};

DepthBuffer empty_buffer(double leaf_size_m, const Camera& camera, const DepthBufferOptions& options) {
  DepthBuffer buffer;
  buffer.camera = camera;
  buffer.leaf_size_m = leaf_size_m;
  buffer.cell_px =
      std::max(1.0, options.cell_leaves * leaf_size_m / options.max_distance_m * camera.pixels_per_radian());
  buffer.wraps = camera.model() == CameraModel::kEquirectangular;
  buffer.margin_cells = buffer.wraps ? 0 : static_cast<int>(std::ceil(options.margin_px / buffer.cell_px));
  const int width = static_cast<int>(std::ceil(camera.width() / buffer.cell_px)) + 2 * buffer.margin_cells;
  const int height = static_cast<int>(std::ceil(camera.height() / buffer.cell_px)) + 2 * buffer.margin_cells;
  buffer.range = RangeImage(width, height, 0.0f);
  return buffer;
}

/// The columns [first, last] as one or two spans inside the row, which are cut off at its ends or continue at the other
/// one where the buffer wraps.
struct Spans {
  std::array<std::array<int, 2>, 2> spans;  // first, last
  int count = 1;

  Spans(int first, int last, const DepthBuffer& buffer) {
    const int width = buffer.range.width;
    spans[0] = {std::max(first, 0), std::min(last, width - 1)};
    if (!buffer.wraps || (first >= 0 && last < width)) return;
    spans[1] = first < 0 ? std::array<int, 2>{first + width, width - 1} : std::array<int, 2>{0, last - width};
    count = 2;
  }
};

/// The bits of positive floats order as the floats do, and compilers vectorise the minimum and maximum of integers.
using RangeBits = Image<int32_t>;

/// Half sizes of the square that a leaf at a range covers.
class SplatSize {
 public:
  SplatSize(const DepthBuffer& buffer, float radius_m)
      : magnification_(buffer), radius_m_(radius_m), max_half_(static_cast<float>((buffer.range.width - 1) / 2)) {}

  Eigen::Vector2i half_cells(const Eigen::Vector2i& cell, float range) const {
    const Eigen::Vector2f half = magnification_.at(cell) * (radius_m_ / range);
    return {static_cast<int>(std::min(half.x() + 0.5f, max_half_)),
            static_cast<int>(std::min(half.y() + 0.5f, max_half_))};
  }

 private:
  Magnification magnification_;
  float radius_m_;
  float max_half_;
};

/// Nearest range per cell.
RangeBits draw(const std::vector<ProjectedLeaf>& leaves, const SplatSize& size, const DepthBuffer& buffer) {
  const int height = buffer.range.height;
  RangeBits nearest(buffer.range.width, height, std::bit_cast<int32_t>(kNoSurface));
  for (const ProjectedLeaf& leaf : leaves) {
    if (!leaf.hides) continue;
    const Eigen::Array2d place = (leaf.pixel.cast<double>().array() + 0.5) / buffer.cell_px + buffer.margin_cells;
    const Eigen::Vector2i cell = place.floor().cast<int>();  // may lie outside, where only its square reaches in
    const Eigen::Vector2i inside(std::clamp(cell.x(), 0, nearest.width - 1), std::clamp(cell.y(), 0, height - 1));
    const Eigen::Vector2i half = size.half_cells(inside, leaf.range);
    const int32_t bits = std::bit_cast<int32_t>(leaf.range);
    const Spans columns(cell.x() - half.x(), cell.x() + half.x(), buffer);
    for (int y = std::max(cell.y() - half.y(), 0); y <= std::min(cell.y() + half.y(), height - 1); ++y) {
      int32_t* row = &nearest.at(0, y);
      for (int s = 0; s < columns.count; ++s) {
        const auto [first, last] = columns.spans[static_cast<size_t>(s)];
        for (int x = first; x <= last; ++x) row[x] = std::min(row[x], bits);
      }
    }
  }
  return nearest;
}

int32_t maximum(const int32_t* values, int first, int last) {
  int32_t result = 0;
  for (int i = first; i <= last; ++i) result = std::max(result, values[i]);
  return result;
}

/// The second half of the closing: each cell takes the largest range in a square as large as the one that had won it,
/// one axis after the other. Where that is no surface at all, 0.
void erode(const RangeBits& nearest, const SplatSize& size, DepthBuffer* buffer) {
  const int width = nearest.width;
  const int height = nearest.height;
  const int32_t no_surface = std::bit_cast<int32_t>(kNoSurface);
  const auto half_at = [&](int x, int y) { return size.half_cells({x, y}, std::bit_cast<float>(nearest.at(x, y))); };
  RangeBits transposed(height, width);
  for (int y = 0; y < height; ++y) {
    const int32_t* row = &nearest.at(0, y);
    for (int x = 0; x < width; ++x) {
      int32_t farthest = no_surface;
      if (row[x] != no_surface) {
        const int half = half_at(x, y).x();
        const Spans columns(x - half, x + half, *buffer);
        farthest = maximum(row, columns.spans[0][0], columns.spans[0][1]);
        if (columns.count == 2) farthest = std::max(farthest, maximum(row, columns.spans[1][0], columns.spans[1][1]));
      }
      transposed.at(y, x) = farthest;
    }
  }
  for (int x = 0; x < width; ++x) {
    const int32_t* column = &transposed.at(0, x);
    for (int y = 0; y < height; ++y) {
      if (column[y] == no_surface) continue;  // range is 0 already
      const int half = half_at(x, y).y();
      const int32_t farthest = maximum(column, std::max(y - half, 0), std::min(y + half, height - 1));
      if (farthest != no_surface) buffer->range.at(x, y) = std::bit_cast<float>(farthest);
    }
  }
}

/// The layer whose nodes are closest to kNodeSizeM, at least a leaf large.
int surroundings_layer(const VoxelMap& map) {
  int layer = map.leaf_layer();
  while (layer > 0 && map.voxel_size(layer - 1) <= kNodeSizeM * 1.001) --layer;
  return layer;
}

/// Both the leaves and the nodes of the roots are ascending: one walk marks the leaves of the nodes that are not
/// extended.
void mark_small_bodies(const VoxelMap& map, const std::vector<uint32_t>& roots, double min_extent,
                       std::vector<ProjectedLeaf>* leaves) {
  const int layer = surroundings_layer(map);
  const std::vector<uint8_t> extended = find_extended_nodes(map, roots, layer, min_extent);
  auto flag = extended.begin();
  auto leaf = leaves->begin();
  for (const uint32_t root : roots) {
    uint32_t begin = root;
    uint32_t end = root + 1;
    for (int l = 0; l < layer; ++l) {
      begin = map.children_begin(l, begin);
      end = map.children_begin(l, end);
    }
    for (uint32_t node = begin; node < end; ++node, ++flag) {
      uint32_t leaves_end = node + 1;
      for (int l = layer; l < map.leaf_layer(); ++l) leaves_end = map.children_begin(l, leaves_end);
      for (; leaf != leaves->end() && leaf->leaf < leaves_end; ++leaf) leaf->hides = *flag != 0;
    }
  }
}

}  // namespace

void DepthBufferOptions::validate() const {
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(cell_leaves > 0, "cell_leaves", "(0, inf)", cell_leaves);
  check_option(splat_radius_leaves > 0, "splat_radius_leaves", "(0, inf)", splat_radius_leaves);
  check_option(margin_px >= 0, "margin_px", "[0, inf)", margin_px);
  check_option(min_occluder_extent >= 0 && min_occluder_extent <= 1, "min_occluder_extent", "[0, 1]",
               min_occluder_extent);
}

std::vector<ProjectedLeaf> project_leaves(const VoxelMap& map, const std::vector<uint32_t>& roots, const Camera& camera,
                                          const Rigid3& camera_from_map, const DepthBufferOptions& options) {
  std::vector<ProjectedLeaf> projected;
  if (map.num_layers() == 0) return projected;
  const int layer = map.leaf_layer();
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  const Eigen::Matrix3f rotation_f = rotation.cast<float>();
  const double splat_px = options.splat_radius_leaves * map.options().leaf_size_m * camera.pixels_per_radian();
  // float32 holds 20 m to a micrometre: the large offsets cancel in double first.
  const Eigen::Vector3d camera_in_map = camera_center(camera_from_map);
  const Eigen::Vector3f camera_from_origin = (camera_in_map - map.origin()).cast<float>();
  for (const uint32_t root : roots) {
    uint32_t begin = root;
    uint32_t end = root + 1;
    for (int l = 0; l < layer; ++l) {
      begin = map.children_begin(l, begin);
      end = map.children_begin(l, end);
    }
    for (uint32_t leaf = begin; leaf < end; ++leaf) {
      const uint32_t points_begin = map.points_begin(layer, leaf);
      const uint32_t points_end = map.points_end(layer, leaf);
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (uint32_t i = points_begin; i < points_end; ++i) sum += map.positions()[i] - camera_from_origin;
      const Eigen::Vector3f x_in_camera = rotation_f * (sum / static_cast<float>(points_end - points_begin));
      const float range = x_in_camera.norm();
      if (!(range > 0.0f) || range > options.max_distance_m) continue;
      const auto pixel = camera.project(x_in_camera.cast<double>());
      const double margin_px = options.margin_px + kMaxMagnification * splat_px / range;
      if (pixel && camera.in_image(*pixel, -0.5 - margin_px))
        projected.push_back({leaf, range, pixel->cast<float>(), true});
    }
  }
  if (options.min_occluder_extent > 0) mark_small_bodies(map, roots, options.min_occluder_extent, &projected);
  return projected;
}

DepthBuffer render_depth_buffer(const std::vector<ProjectedLeaf>& leaves, double leaf_size_m, const Camera& camera,
                                const DepthBufferOptions& options) {
  options.validate();
  DepthBuffer buffer = empty_buffer(leaf_size_m, camera, options);
  const SplatSize size(buffer, static_cast<float>(options.splat_radius_leaves * leaf_size_m));
  erode(draw(leaves, size, buffer), size, &buffer);
  return buffer;
}

DepthBuffer render_depth_buffer(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                const DepthBufferOptions& options) {
  options.validate();
  const double widening = options.margin_px / camera.pixels_per_radian();
  const std::vector<uint32_t> roots = select_roots(map, camera, camera_from_map, options.max_distance_m, widening);
  const std::vector<ProjectedLeaf> leaves = project_leaves(map, roots, camera, camera_from_map, options);
  return render_depth_buffer(leaves, map.options().leaf_size_m, camera, options);
}

}  // namespace cpplus
