#include "cpplus/visibility/plane_buffer_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cpplus/cloud/map_tiles.h"
#include "cpplus/geometry/tangent_box.h"
#include "cpplus/visibility/range_keys.h"

namespace cpplus {
namespace {

// The patch of a leaf reaches a little beyond it, so that neighbouring patches of sparse surfaces close.
constexpr double kPatchRadiusLeaves = 0.7;
constexpr double kMaxPatchRadiusPx = 64.0;

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
      : cell_px_(cell_px),
        nearest_(static_cast<int>(std::ceil(camera.width() / cell_px)),
                 static_cast<int>(std::ceil(camera.height() / cell_px)), kNoRangeKey) {}

  // The cell of the patch's centre at its range; those that lie within the patch around it at its rim's range, so that
  // a patch drawn over the neighbours of its own plane never wins over the patch that belongs there.
  void draw(const Eigen::Vector2d& pixel, double radius_px, float range, float rim_range, int32_t plane) {
    const Eigen::Vector2d cell = (pixel.array() + 0.5) / cell_px_;
    const double radius = radius_px / cell_px_;
    const int cx = static_cast<int>(std::floor(cell.x()));
    const int cy = static_cast<int>(std::floor(cell.y()));
    const int x0 = std::max(0, std::min(cx, static_cast<int>(std::floor(cell.x() - radius + 0.5))));
    const int x1 = std::min(nearest_.width - 1, std::max(cx, static_cast<int>(std::floor(cell.x() + radius - 0.5))));
    const int y0 = std::min(cy, static_cast<int>(std::floor(cell.y() - radius + 0.5)));
    const int y1 = std::max(cy, static_cast<int>(std::floor(cell.y() + radius - 0.5)));
    draw_rectangle(x0, x1, y0, y1, range_key(rim_range, static_cast<uint32_t>(plane)), &nearest_);
    if (!nearest_.contains(cx, cy)) return;
    nearest_.at(cx, cy) = std::min(nearest_.at(cx, cy), range_key(range, static_cast<uint32_t>(plane)));
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
  double cell_px_;
  Image<RangeKey> nearest_;
};

}  // namespace

PlaneBuffer render_plane_buffer(const VoxelMap& map, const PlaneSegmentation& planes, const PlaneSurface& surface,
                                const Camera& camera, const Rigid3& camera_from_map,
                                const PlaneBufferOptions& options) {
  Canvas canvas(camera, options.cell_px);
  const double radius_m = kPatchRadiusLeaves * map.options().leaf_size_m;
  const Eigen::Matrix3d rotation = camera_from_map.rotation.toRotationMatrix();
  const Eigen::Vector3d offset = rotation * map.origin() + camera_from_map.translation;
  const TangentBox box = tangent_box(camera);
  const auto draw_patch = [&](size_t k) {
    const Eigen::Vector3d x = rotation * surface.centers[k].cast<double>() + offset;
    if (box.excludes(x.cast<float>(), static_cast<float>(radius_m))) return;
    const double range = x.norm();
    if (range > options.max_distance_m || range < 1e-3) return;
    const auto pixel = camera.project(x);
    if (!pixel) return;
    const double radius_px = std::min(radius_m / range * camera.pixels_per_radian(), kMaxPatchRadiusPx);
    if (!camera.in_image(*pixel, -radius_px)) return;
    const MapPlane& plane = planes.planes[static_cast<size_t>(surface.plane_of[k])];
    const double cosine = plane.normal.dot(rotation.transpose() * x) / range;
    const double rim_range = range + radius_m * std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    canvas.draw(*pixel, radius_px, static_cast<float>(range), static_cast<float>(rim_range), surface.plane_of[k]);
  };

  const Eigen::Vector3d axis = camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  for (const uint32_t root :
       map.roots_in_frustum(camera_center(camera_from_map), axis, camera.max_view_angle(), options.max_distance_m)) {
    const auto [leaf_begin, leaf_end] = leaves_of_root(map, root);
    const auto first = std::lower_bound(surface.leaves.begin(), surface.leaves.end(), leaf_begin);
    const auto last = std::lower_bound(first, surface.leaves.end(), leaf_end);
    for (auto it = first; it != last; ++it) draw_patch(static_cast<size_t>(it - surface.leaves.begin()));
  }

  PlaneBuffer buffer;
  buffer.camera = camera;
  buffer.camera_from_map = camera_from_map;
  buffer.cell_px = options.cell_px;
  canvas.copy_to(&buffer);
  buffer.planes = &planes.planes;
  return buffer;
}

}  // namespace cpplus
