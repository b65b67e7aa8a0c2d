#include "cpplus/visibility/depth_buffer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cpplus/core/options.h"
#include "cpplus/visibility/extended_surfaces.h"

namespace cpplus {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();
constexpr int kMaxHalfCells = 255;
constexpr int kBlockCells = 16;
/// Bodies of up to about a metre count as small whatever the leaves are: surroundings are cubes of three such nodes.
constexpr double kNodeSizeM = 0.25;

using HalfCells = Image<std::array<uint8_t, 2>>;

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
  buffer.range = RangeImage(width, height, kNoSurface);
  return buffer;
}

/// Nearest range per cell into buffer->range, and the half size of the square that won.
void draw(const std::vector<ProjectedLeaf>& leaves, float radius_m, DepthBuffer* buffer, HalfCells* half) {
  const Magnification magnification(*buffer);
  const int width = buffer->range.width;
  const int height = buffer->range.height;
  const int max_half = std::min(kMaxHalfCells, (width - 1) / 2);
  for (const ProjectedLeaf& leaf : leaves) {
    if (!leaf.hides) continue;
    const Eigen::Vector2i cell = buffer->cell_of(leaf.pixel.cast<double>());
    if (!buffer->range.contains(cell.x(), cell.y())) continue;
    const Eigen::Vector2f radius = magnification.at(cell) * (radius_m / leaf.range);
    const int half_x = static_cast<int>(std::min(radius.x() + 0.5f, static_cast<float>(max_half)));
    const int half_y = static_cast<int>(std::min(radius.y() + 0.5f, static_cast<float>(max_half)));
    const int begin_x = buffer->wraps ? cell.x() - half_x : std::max(cell.x() - half_x, 0);
    const int end_x = buffer->wraps ? cell.x() + half_x : std::min(cell.x() + half_x, width - 1);
    for (int y = std::max(cell.y() - half_y, 0); y <= std::min(cell.y() + half_y, height - 1); ++y) {
      for (int x = begin_x; x <= end_x; ++x) {
        const int column = buffer->column(x);
        float& range = buffer->range.at(column, y);
        if (leaf.range >= range) continue;
        range = leaf.range;
        half->at(column, y) = {static_cast<uint8_t>(half_x), static_cast<uint8_t>(half_y)};
      }
    }
  }
}

/// The second half of the closing: each cell takes the largest range within the square that had won it, one axis
/// after the other. kNoSurface becomes 0.
void erode(const HalfCells& half, DepthBuffer* buffer) {
  const int width = buffer->range.width;
  const int height = buffer->range.height;
  RangeImage along_rows(width, height);
  for (int y = 0; y < height; ++y) {
    const float* row = &buffer->range.at(0, y);
    for (int x = 0; x < width; ++x) {
      const int half_x = half.at(x, y)[0];
      const int begin = buffer->wraps ? x - half_x : std::max(x - half_x, 0);
      const int end = buffer->wraps ? x + half_x : std::min(x + half_x, width - 1);
      float farthest = 0.0f;
      for (int u = begin; u <= end; ++u) farthest = std::max(farthest, row[buffer->column(u)]);
      along_rows.at(x, y) = farthest;
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int half_y = half.at(x, y)[1];
      float farthest = 0.0f;
      for (int v = std::max(y - half_y, 0); v <= std::min(y + half_y, height - 1); ++v)
        farthest = std::max(farthest, along_rows.at(x, v));
      buffer->range.at(x, y) = farthest == kNoSurface ? 0.0f : farthest;
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

std::vector<uint32_t> select_roots(const VoxelMap& map, const Camera& camera, const Rigid3& camera_from_map,
                                   double max_distance_m, double widening) {
  const Eigen::Vector3d axis_in_map = camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double half_angle = std::min(camera.max_view_angle() + widening, M_PI);
  return map.roots_in_frustum(camera_center(camera_from_map), axis_in_map, half_angle, max_distance_m);
}

std::vector<ProjectedLeaf> project_leaves(const VoxelMap& map, const std::vector<uint32_t>& roots, const Camera& camera,
                                          const Rigid3& camera_from_map, const DepthBufferOptions& options) {
  std::vector<ProjectedLeaf> projected;
  if (map.num_layers() == 0) return projected;
  const int layer = map.leaf_layer();
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  const Eigen::Matrix3f rotation_f = rotation.cast<float>();
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
      if (pixel && camera.in_image(*pixel, -0.5 - options.margin_px))
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
  HalfCells half(buffer.range.width, buffer.range.height, {0, 0});
  draw(leaves, static_cast<float>(options.splat_radius_leaves * leaf_size_m), &buffer, &half);
  erode(half, &buffer);
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
