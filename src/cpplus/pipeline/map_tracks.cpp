#include "cpplus/pipeline/map_tracks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "cpplus/colorize/robust_color.h"
#include "cpplus/core/memory.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"
#include "cpplus/visibility/point_spacing.h"

namespace cpplus {
namespace {

constexpr size_t kGrain = 2048;
constexpr double kNormalVoxelM = 0.25;
constexpr int kMaxColorSamples = 8;
/// Of the points that a closed surface through the middle of 3 x 3 x 3 leaves would have in them.
constexpr double kMinSurfaceShare = 0.2;
constexpr double kMaxColorDeviation = 30.0;  // grey levels, as in colorize

/// The finest layer whose voxels are at least voxel_m large. (The allowance makes 0.25 m mean the layer of 0.25 m.)
int layer_of(const VoxelMap& map, double voxel_m) {
  int layer = 0;
  while (layer < map.leaf_layer() && map.voxel_size(layer + 1) >= voxel_m * (1.0 - 1e-9)) ++layer;
  return layer;
}

uint32_t point_nearest_to_mean(const VoxelMap& map, uint32_t begin, uint32_t end) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (uint32_t i = begin; i < end; ++i) sum += map.positions()[i].cast<double>();
  const Eigen::Vector3f mean = (sum / static_cast<double>(end - begin)).cast<float>();
  uint32_t nearest = begin;
  float smallest = std::numeric_limits<float>::infinity();
  for (uint32_t i = begin; i < end; ++i) {
    const float distance = (map.positions()[i] - mean).squaredNorm();
    if (distance < smallest) {
      smallest = distance;
      nearest = i;
    }
  }
  return nearest;
}

/// Whether the leaf and its neighbours hold enough points for the surface they would be a part of: what lidars see in
/// the air beside an outline (mixed pixels), and single points, do not.
bool is_on_surface(const VoxelMap& map, const std::vector<float>& leaf_spacing_m, uint32_t leaf,
                   std::vector<uint32_t>* neighbors) {
  const double spacing_m = leaf_spacing_m[leaf];
  if (!std::isfinite(spacing_m)) return false;
  map.neighbors(map.leaf_layer(), leaf, false, neighbors);
  size_t count = map.num_points(map.leaf_layer(), leaf);
  for (const uint32_t neighbor : *neighbors) count += map.num_points(map.leaf_layer(), neighbor);
  const double across = 3.0 * map.options().leaf_size_m / spacing_m;
  return static_cast<double>(count) >= kMinSurfaceShare * across * across;
}

std::vector<uint32_t> sample_points(const VoxelMap& map, double voxel_m) {
  if (map.num_points() == 0) return {};
  const int layer = layer_of(map, voxel_m);
  const std::vector<float> leaf_spacing_m = leaf_point_spacing(map);
  std::vector<uint32_t> points(map.num_nodes(layer));
  parallel_for_chunks(points.size(), kGrain, [&](size_t begin, size_t end) {
    std::vector<uint32_t> neighbors;
    for (size_t node = begin; node < end; ++node) {
      const uint32_t id = static_cast<uint32_t>(node);
      points[node] = point_nearest_to_mean(map, map.points_begin(layer, id), map.points_end(layer, id));
      const auto leaf = map.find_leaf(map.point(points[node]));
      if (!leaf || !is_on_surface(map, leaf_spacing_m, *leaf, &neighbors)) points[node] = no_voxel;
    }
  });
  std::erase(points, no_voxel);
  return points;
}

/// The normals of some points (ascending).
std::vector<Eigen::Vector3f> normals_at(const VoxelMap& map, const std::vector<uint32_t>& points) {
  const SurfaceNormals normals = estimate_surface_normals(map, kNormalVoxelM);
  std::vector<Eigen::Vector3f> result;
  result.reserve(points.size());
  uint32_t node = 0;
  for (const uint32_t point : points) {
    while (map.points_end(normals.layer, node) <= point) ++node;
    result.push_back(normals.of_node[node]);
  }
  return result;
}

}  // namespace

void MapTrackOptions::validate() const {
  check_option(point_voxel_m > 0, "point_voxel_m", "(0, inf)", point_voxel_m);
  check_option(max_points >= 1 && max_points <= 100000000, "max_points", "[1, 100000000]", max_points);
  check_option(min_views >= 1 && min_views <= 1000, "min_views", "[1, 1000]", min_views);
}

namespace {

// As the images show it, whatever their exposure: points of a sparse model are for orientation.
Rgb color_of(std::span<const ColorSample> samples) {
  std::vector<WeightedColor> colors;
  for (const ColorSample& s : samples) {
    colors.push_back({{static_cast<float>(s.color[0]), static_cast<float>(s.color[1]), static_cast<float>(s.color[2])},
                      static_cast<float>(s.weight)});
  }
  return robust_color(colors, kMaxColorDeviation).color;
}

}  // namespace

MapTracks::MapTracks(const VoxelMap& map, const MapTrackOptions& options, const ViewSamplingOptions& sampling)
    : map_(map),
      options_(options),
      sampling_(sampling),
      points_(sample_points(map, options.point_voxel_m)),
      normals_(normals_at(map, points_)),
      samples_(points_.size(), kMaxColorSamples) {}

size_t MapTracks::add_view(const ColorView& view, uint32_t image_id) {
  const ViewSampler sampler(view, bearings_.of(view.depth), sampling_);
  const Eigen::Matrix3d rotation = view.camera_from_map.rotation.toRotationMatrix();
  std::vector<std::vector<uint32_t>> seen_of_chunk((points_.size() + kGrain - 1) / kGrain);
  parallel_for_chunks(points_.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const Eigen::Vector3d x_in_camera = rotation * map_.point(points_[k]) + view.camera_from_map.translation;
      if (const auto sample = sampler.sample(x_in_camera, rotation * normals_[k].cast<double>())) {
        samples_.add(k, {sample->color, share_in_8_bits(sample->weight, 1), static_cast<uint16_t>(views_.size()), 0});
        seen_of_chunk[begin / kGrain].push_back(static_cast<uint32_t>(k));
      }
    }
  });
  View& added = views_.emplace_back(View{image_id, view.camera, view.camera_from_map, {}});
  for (const std::vector<uint32_t>& seen : seen_of_chunk) added.seen.insert(added.seen.end(), seen.begin(), seen.end());
  return added.seen.size();
}

std::vector<int64_t> MapTracks::choose_points() const {
  const auto is_seen = [&](size_t k) { return static_cast<int>(samples_.num_views(k)) >= options_.min_views; };
  int64_t num_seen = 0;
  for (size_t k = 0; k < points_.size(); ++k) num_seen += is_seen(k) ? 1 : 0;
  const int64_t num_kept = std::min<int64_t>(num_seen, options_.max_points);

  std::vector<int64_t> chosen(points_.size(), -1);
  int64_t rank = 0;
  for (size_t k = 0; k < points_.size(); ++k) {
    if (!is_seen(k)) continue;
    // Of num_seen points num_kept at equal steps, which in map order are spread evenly over the surface.
    const int64_t index = rank * num_kept / num_seen;
    if ((rank + 1) * num_kept / num_seen != index) chosen[k] = index;
    ++rank;
  }
  return chosen;
}

std::vector<SparsePoint> MapTracks::take() {
  const std::vector<int64_t> chosen = choose_points();
  std::vector<SparsePoint> points;
  for (size_t k = 0; k < points_.size(); ++k) {
    if (chosen[k] < 0) continue;
    SparsePoint& point = points.emplace_back();
    point.id = points.size();
    point.position = map_.point(points_[k]);
    point.color = color_of(samples_.of_point(k));
    point.error_px = 0.0;
  }
  for (View& view : views_) {
    for (const uint32_t k : view.seen) {
      if (chosen[k] < 0) continue;
      SparsePoint& point = points[static_cast<size_t>(chosen[k])];
      if (const auto pixel = view.camera.project(view.camera_from_map * point.position)) {
        point.track.push_back({view.image_id, *pixel});
      }
    }
    free_memory(&view.seen);
  }
  return points;
}

}  // namespace cpplus
