#include "cpplus/visibility/plane_buffer_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "cpplus/cloud/node_range.h"
#include "cpplus/visibility/nodes_in_view.h"
#include "cpplus/visibility/point_block.h"
#include "cpplus/visibility/range_keys.h"

namespace cpplus {
namespace {

// The patch of a leaf reaches a little beyond it, so that neighbouring patches of sparse surfaces close.
constexpr double kPatchRadiusLeaves = 0.7;
constexpr float kMaxPatchRadiusPx = 64.0f;
constexpr int kNodeLayersAboveLeaves = 2;

double patch_radius_m(const VoxelMap& map) { return kPatchRadiusLeaves * map.options().leaf_size_m; }

// As std::lower_bound, for a value that is probably found near the beginning.
template <typename Iterator>
Iterator lower_bound_near(Iterator begin, Iterator end, uint32_t value) {
  std::ptrdiff_t step = 8;
  while (end - begin > step && *(begin + step) < value) {
    begin += step;
    step *= 2;
  }
  return std::lower_bound(begin, end - begin > step ? begin + step + 1 : end, value);
}

}  // namespace

void PlaneBufferOptions::validate() const {
  check_option(cell_px >= 1, "cell_px", "[1, inf)", cell_px);
  check_option(max_distance_m > 0, "max_distance_m", "(0, inf)", max_distance_m);
  check_option(min_plane_points >= 0, "min_plane_points", "[0, inf)", min_plane_points);
}

PlaneSurface collect_plane_surface(const VoxelMap& map, const PlaneSegmentation& planes,
                                   const PlaneBufferOptions& options) {
  PlaneSurface surface;
  std::vector<std::pair<int32_t, Eigen::Vector4d>> sums;  // plane, (sum, count), of one leaf
  for (uint32_t leaf = 0; map.num_points() > 0 && leaf < map.num_nodes(map.leaf_layer()); ++leaf) {
    sums.clear();
    for (uint32_t i = map.points_begin(map.leaf_layer(), leaf); i < map.points_end(map.leaf_layer(), leaf); ++i) {
      const int32_t id = planes.plane_of_point[i];
      if (id < 0 ||
          planes.planes[static_cast<size_t>(id)].num_points < static_cast<uint32_t>(options.min_plane_points)) {
        continue;
      }
      auto it = std::find_if(sums.begin(), sums.end(), [&](const auto& s) { return s.first == id; });
      if (it == sums.end()) it = sums.insert(sums.end(), {id, Eigen::Vector4d::Zero()});
      it->second += map.positions()[i].cast<double>().homogeneous();
    }
    for (const auto& [id, sum] : sums) {
      surface.leaves.push_back(leaf);
      surface.plane_of.push_back(id);
      surface.centers.push_back((sum.head<3>() / sum.w()).cast<float>());
    }
  }
  return surface;
}

namespace {

// Draws patches into the cells, the nearest plane of each cell winning.
class Canvas {
 public:
  Canvas(const Camera& camera, double cell_px)
      : inverse_cell_(static_cast<float>(1.0 / cell_px)),
        nearest_(static_cast<int>(std::ceil(camera.width() / cell_px)),
                 static_cast<int>(std::ceil(camera.height() / cell_px)), kNoRangeKey) {}

  // The cell of the patch's centre at its range; those that lie within the patch around it at its rim's range, so that
  // a patch drawn over the neighbours of its own plane never wins over the patch that belongs there.
  void draw(const Eigen::Vector2f& pixel, float radius_px, float range, float rim_range, int32_t plane) {
    const Eigen::Array2f cell = (pixel.array() + 0.5f) * inverse_cell_;
    const float radius = radius_px * inverse_cell_;
    const Eigen::Array2i center = cell.floor().cast<int>();
    const Eigen::Array2i low = (cell - radius + 0.5f).floor().cast<int>().min(center);
    const Eigen::Array2i high = (cell + radius - 0.5f).floor().cast<int>().max(center);
    draw_rectangle(std::max(0, low.x()), std::min(nearest_.width - 1, high.x()), low.y(), high.y(),
                   range_key(rim_range, static_cast<uint32_t>(plane)), &nearest_);
    if (!nearest_.contains(center.x(), center.y())) return;
    RangeKey& at_center = nearest_.at(center.x(), center.y());
    at_center = std::min(at_center, range_key(range, static_cast<uint32_t>(plane)));
  }

  void copy_to(PlaneBuffer* buffer) const {
    buffer->plane = Image<int32_t>(nearest_.width, nearest_.height, PlaneBuffer::kNone);
    buffer->range_bound = RangeImage(nearest_.width, nearest_.height, std::numeric_limits<float>::max());
    for (size_t i = 0; i < nearest_.pixels.size(); ++i) {
      if (nearest_.pixels[i] == kNoRangeKey) continue;
      buffer->plane.pixels[i] = static_cast<int32_t>(what_of(nearest_.pixels[i]));
      buffer->range_bound.pixels[i] = range_of(nearest_.pixels[i]);
    }
  }

 private:
  float inverse_cell_;
  Image<RangeKey> nearest_;
};

// Draws the patches of runs of leaves as one camera sees them.
class PatchDrawer {
 public:
  PatchDrawer(const VoxelMap& map, const PlaneSegmentation& planes, const PlaneSurface& surface, const Camera& camera,
              const Rigid3& camera_from_map, const PlaneBufferOptions& options)
      : surface_(surface),
        camera_(camera),
        radius_m_(static_cast<float>(patch_radius_m(map))),
        max_distance_m_(static_cast<float>(options.max_distance_m)),
        canvas_(camera, options.cell_px),
        block_(camera, camera_from_map, map.origin()) {
    const Eigen::Matrix3f rotation = camera_from_map.rotation.toRotationMatrix().cast<float>();
    for (const MapPlane& plane : planes.planes) normals_in_camera_.push_back(rotation * plane.normal.cast<float>());
  }

  // Patches [begin, end) of the surface.
  void add(size_t begin, size_t end) {
    for (; begin < end; ++begin) {
      plane_[block_.size()] = surface_.plane_of[begin];
      block_.add(surface_.centers[begin]);
      if (block_.full()) flush();
    }
  }

  void flush() {
    block_.project();
    const float pixels_per_radian = static_cast<float>(camera_.pixels_per_radian());
    const float last_column = static_cast<float>(camera_.width() - 1);
    const float last_row = static_cast<float>(camera_.height() - 1);
    for (size_t i = 0; i < block_.size(); ++i) {
      const float range = block_.range(i);
      if (range > max_distance_m_ || range < 1e-3f) continue;
      const Eigen::Vector2f pixel(block_.column(i), block_.row(i));
      const float radius_px = std::min(radius_m_ / range * pixels_per_radian, kMaxPatchRadiusPx);
      const bool in_image = (pixel.x() >= -radius_px) & (pixel.y() >= -radius_px) &
                            (pixel.x() <= last_column + radius_px) & (pixel.y() <= last_row + radius_px);
      if (!in_image) continue;  // NaN: nowhere
      const Eigen::Vector3f x(block_.x(i), block_.y(i), block_.z(i));
      const float cosine = normals_in_camera_[static_cast<size_t>(plane_[i])].dot(x) / range;
      const float rim_range = range + radius_m_ * std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
      canvas_.draw(pixel, radius_px, range, rim_range, plane_[i]);
    }
    block_.clear();
  }

  const Canvas& canvas() const { return canvas_; }

 private:
  const PlaneSurface& surface_;
  const Camera& camera_;
  float radius_m_;
  float max_distance_m_;
  Canvas canvas_;
  std::vector<Eigen::Vector3f> normals_in_camera_;  // by plane
  PointBlock block_;
  std::array<int32_t, PointBlock::kSize> plane_;
};

// The layer whose nodes are looked at whole: some tens of patches each.
int node_layer(const VoxelMap& map) { return std::max(0, map.leaf_layer() - kNodeLayersAboveLeaves); }

}  // namespace

PlaneBuffer render_plane_buffer(const VoxelMap& map, const PlaneSegmentation& planes, const PlaneSurface& surface,
                                const Camera& camera, const Rigid3& camera_from_map,
                                const PlaneBufferOptions& options) {
  PatchDrawer drawer(map, planes, surface, camera, camera_from_map, options);
  auto first = surface.leaves.begin();
  for (const uint32_t node : nodes_in_view(map, node_layer(map), camera, camera_from_map, options.max_distance_m,
                                           patch_radius_m(map), HiddenRanges())) {
    const auto [leaf_begin, leaf_end] = leaves_of(map, node_layer(map), node);
    first = lower_bound_near(first, surface.leaves.end(), leaf_begin);
    const auto last = lower_bound_near(first, surface.leaves.end(), leaf_end);
    drawer.add(static_cast<size_t>(first - surface.leaves.begin()), static_cast<size_t>(last - surface.leaves.begin()));
    first = last;
  }
  drawer.flush();

  PlaneBuffer buffer;
  buffer.camera = camera;
  buffer.camera_from_map = camera_from_map;
  buffer.cell_px = options.cell_px;
  drawer.canvas().copy_to(&buffer);
  buffer.planes = &planes.planes;
  return buffer;
}

}  // namespace cpplus
