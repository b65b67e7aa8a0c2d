#include "cpplus/dynamics/see_through.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>

#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/leaf_vote.h"
#include "cpplus/dynamics/ray_grid.h"
#include "cpplus/dynamics/scan_hits.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr size_t kScansPerTask = 2;  // they share the working memory, one bit a leaf

/// The leaves that a scan hits, one bit each.
class LeafSet {
 public:
  explicit LeafSet(size_t num_leaves) : words_((num_leaves + 63) / 64, 0) {}

  bool contains(uint32_t leaf) const { return (words_[leaf / 64] >> (leaf % 64) & 1) != 0; }
  void insert(std::span<const LeafHit> hits) {
    for (const LeafHit& hit : hits) words_[hit.leaf / 64] |= uint64_t{1} << (hit.leaf % 64);
  }
  void erase(std::span<const LeafHit> hits) {
    for (const LeafHit& hit : hits) words_[hit.leaf / 64] = 0;
  }

 private:
  std::vector<uint64_t> words_;
};

/// Leaves off planes that one scan alone hits, and the nodes above them.
class LoneLeaves {
 public:
  LoneLeaves(const VoxelMap& map, const LeafSurfaces& surfaces) : surfaces_(surfaces), holds_(map.leaf_layer()) {
    for (int layer = map.leaf_layer() - 1; layer >= 0; --layer) {
      std::vector<uint8_t>& holds = holds_[static_cast<size_t>(layer)];
      holds.resize(map.num_nodes(layer), 0);
      parallel_for_chunks(holds.size(), kNodesPerTask, [&](size_t begin, size_t end) {
        for (auto node = static_cast<uint32_t>(begin); node < end; ++node) holds[node] = is_any_child(map, layer, node);
      });
    }
  }

  bool contains(uint32_t leaf) const { return surfaces_.num_scans[leaf] == 1 && surfaces_.normals[leaf].isZero(0.0f); }
  /// Whether one of them is in a node of a layer above the leaves.
  bool are_in(int layer, uint32_t node) const { return holds_[static_cast<size_t>(layer)][node] != 0; }

 private:
  static constexpr size_t kNodesPerTask = 1 << 14;

  bool is_any_child(const VoxelMap& map, int layer, uint32_t node) const {
    for (uint32_t child = map.children_begin(layer, node); child < map.children_begin(layer, node + 1); ++child) {
      if (layer + 1 == map.leaf_layer() ? contains(child) : are_in(layer + 1, child)) return true;
    }
    return false;
  }

  const LeafSurfaces& surfaces_;
  std::vector<std::vector<uint8_t>> holds_;  // by layer and node
};

/// Finds what the scans see through, one scan after the other.
class ScanCaster {
 public:
  ScanCaster(const VoxelMap& map, const ScanSet& scans, const ScanHits& hits, const LeafSurfaces& surfaces,
             const LoneLeaves& lone, const DynamicsOptions& options, std::vector<uint32_t>* missing,
             std::vector<uint32_t>* num_near)
      : map_(map),
        scans_(scans),
        hits_(hits),
        surfaces_(surfaces),
        lone_(lone),
        options_(options),
        max_range_(static_cast<float>(options.max_range_m)),
        radius_(static_cast<float>(options.ray_radius_m)),
        near_sine_(static_cast<float>(std::sin(options.near_grazing_deg * M_PI / 180.0))),
        near_radius_(static_cast<float>(options.near_radius_m)),
        min_sine_(static_cast<float>(std::sin(options.min_grazing_deg * M_PI / 180.0))),
        missing_(missing->data()),
        num_near_(num_near->data()),
        hit_(surfaces.num_scans.size()) {}

  /// Takes one from `missing` of each leaf that the scan sees through, and adds one to `num_near` of each near which it
  /// does.
  void cast(size_t scan) {
    const Vector3d& sensor_in_map = scans_.sensors_in_map[scan];
    sensor_ = (sensor_in_map - map_.origin()).cast<float>();
    hit_.insert(hits_.of(scan));
    collect_rays(scan);
    grid_.assign(rays_);
    for (const uint32_t root : map_.roots_in_radius(sensor_in_map, options_.max_range_m)) {
      const Vector3d center = map_.center(0, root) - sensor_in_map;
      visit(0, root, {center.cast<float>(), static_cast<float>(0.5 * map_.options().root_size_m)});
    }
    hit_.erase(hits_.of(scan));
  }

 private:
  /// One ray for each leaf that the scan hits.
  void collect_rays(size_t scan) {
    rays_.clear();
    for (const LeafHit& hit : hits_.of(scan)) {
      const Vector3f ray = map_.positions()[hit.point] - sensor_;
      const float range = ray.norm();
      if (range <= 0.0f) continue;
      const Vector3f direction = ray / range;
      const float distance = safe_distance(direction, range, hit.leaf);
      if (distance > 0.0f) rays_.push_back({direction, distance});
    }
  }

  /// How far the ray to a point of the leaf may be followed: the safe maximum search distance.
  float safe_distance(const Vector3f& direction, float range, uint32_t leaf) const {
    constexpr double kMinSine = 0.01;
    const Vector3f& normal = surfaces_.normals[leaf];
    const bool on_plane = !normal.isZero(0.0f);
    const double sine = std::max(kMinSine, std::abs(static_cast<double>(normal.dot(direction))));
    const double surface_gap = on_plane ? options_.surface_gap_m / sine : options_.range_gap * range;
    const double gap = std::max(options_.min_gap_m, surface_gap);
    return static_cast<float>(std::min(options_.max_range_m, static_cast<double>(range) - gap));
  }

  /// Goes down to the leaves in front of the ends of rays; all others are left out by whole nodes.
  void visit(int layer, uint32_t node, const SensorCube& cube) {
    if (layer == map_.leaf_layer()) return visit_leaf(node, cube);
    const SensorCube wide{cube.center, cube.half_m + (lone_.are_in(layer, node) ? near_radius_ : 0.0f)};
    const float nearest = wide.distance();
    if (nearest > max_range_ || grid_.reach(wide) < nearest) return;
    const float half = 0.5f * cube.half_m;
    for (int octant = 0; octant < 8; ++octant) {
      const uint32_t child = map_.child_in_octant(layer, node, octant);
      if (child == no_voxel) continue;
      const Vector3f side((octant & 1) != 0 ? half : -half, (octant & 2) != 0 ? half : -half,
                          (octant & 4) != 0 ? half : -half);
      visit(layer + 1, child, {cube.center + side, half});
    }
  }

  void visit_leaf(uint32_t leaf, const SensorCube& cube) {
    if (!is_missing(leaf) || hit_.contains(leaf)) return;
    const bool passed = is_passed(leaf, cube);
    const bool passed_near = lone_.contains(leaf) && (passed || is_passed_near(leaf));
    if ((!passed && !passed_near) || is_beside_hit(leaf)) return;
    if (passed) missing(leaf).fetch_sub(1, std::memory_order_relaxed);
    if (passed_near) std::atomic_ref(num_near_[leaf]).fetch_add(1, std::memory_order_relaxed);
  }

  /// Whether a ray meets the leaf's cube, within the radius of its mean, and not at a grazing angle.
  bool is_passed(uint32_t leaf, const SensorCube& cube) const {
    const Vector3f to_mean = surfaces_.means[leaf] - sensor_;
    const Vector3f& normal = surfaces_.normals[leaf];
    const float min_sine = normal.isZero(0.0f) ? 0.0f : min_sine_;
    // Whatever passes the mean within the radius grazes then: most of the ground goes here.
    const float shortest = shortest_way_to(to_mean, radius_);
    if (std::abs(normal.dot(to_mean)) + radius_ < min_sine * shortest) return false;
    return any_ray_passes(to_mean, radius_, shortest, cube, [&](const Vector3f& direction, float, float) {
      return std::abs(normal.dot(direction)) >= min_sine && line_meets(direction, cube);
    });
  }

  /// Whether a ray passes within the larger radius, and goes on so far that it is none that ends on a surface through
  /// the leaf that it grazes: far ground, of which no plane is known.
  bool is_passed_near(uint32_t leaf) const {
    const Vector3f to_mean = surfaces_.means[leaf] - sensor_;
    return any_ray_passes(to_mean, near_radius_, shortest_way_to(to_mean, near_radius_), {to_mean, near_radius_},
                          [&](const Vector3f&, float off2, float left) { return off2 <= square(near_sine_ * left); });
  }

  static float square(float value) { return value * value; }

  /// How far a ray must go at least to pass the mean within the radius.
  static float shortest_way_to(const Vector3f& to_mean, float radius) {
    return std::sqrt(std::max(0.0f, to_mean.squaredNorm() - radius * radius));
  }

  /// Whether a ray passes the mean within the radius before it ends; asks those that may meet the cube.
  template <typename Accept>
  bool any_ray_passes(const Vector3f& to_mean, float radius, float shortest, const SensorCube& cube,
                      const Accept& accept) const {
    if (grid_.reach(cube) < shortest) return false;
    const float range2 = to_mean.squaredNorm();
    return grid_.any_ray(cube, [&](const ScanRay& ray) {
      if (ray.length_m < shortest) return false;
      const float along = to_mean.dot(ray.direction);
      const float off2 = range2 - along * along;
      return along <= ray.length_m && along > 0.0f && off2 <= radius * radius &&
             accept(ray.direction, off2, ray.length_m - along);
    });
  }

  /// Whether the scan hits one of the 26 leaves around, on the same surface as far as one knows.
  bool is_beside_hit(uint32_t leaf) {
    map_.neighbors(map_.leaf_layer(), leaf, false, &neighbors_);
    return std::any_of(neighbors_.begin(), neighbors_.end(), [&](uint32_t neighbor) {
      if (!hit_.contains(neighbor)) return false;
      const Vector3f& normal = surfaces_.normals[neighbor];
      const float distance = normal.dot(surfaces_.means[leaf] - surfaces_.means[neighbor]);
      return normal.isZero(0.0f) || std::abs(distance) < static_cast<float>(options_.plane_distance_m);
    });
  }

  /// Shared by all threads. Once it is not positive, as a signed number, it stays so, and what is below zero does not
  /// count.
  std::atomic_ref<uint32_t> missing(uint32_t leaf) const { return std::atomic_ref(missing_[leaf]); }
  bool is_missing(uint32_t leaf) const {
    return static_cast<int32_t>(missing(leaf).load(std::memory_order_relaxed)) > 0;
  }

  const VoxelMap& map_;
  const ScanSet& scans_;
  const ScanHits& hits_;
  const LeafSurfaces& surfaces_;
  const LoneLeaves& lone_;
  const DynamicsOptions& options_;
  const float max_range_;
  const float radius_;
  const float near_sine_;
  const float near_radius_;
  const float min_sine_;
  uint32_t* missing_;
  uint32_t* num_near_;
  // Of the scan at hand:
  Vector3f sensor_;  // relative to the map's origin
  LeafSet hit_;
  std::vector<ScanRay> rays_;
  RayGrid grid_;
  std::vector<uint32_t> neighbors_;
};

}  // namespace

SeeThrough count_see_through(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                             const DynamicsOptions& options) {
  const size_t num_leaves = surfaces.num_scans.size();
  std::vector<uint32_t> missing(num_leaves);
  const auto sufficient = [&](size_t leaf) {
    return sufficient_scans(surfaces.num_scans[leaf], scans.num_scans(), options);
  };
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) missing[leaf] = sufficient(leaf);
  std::vector<uint32_t> num_near(num_leaves, 0);
  const LoneLeaves lone(map, surfaces);
  const ScanHits hits = find_scan_hits(map, scans);
  parallel_for_chunks(scans.num_scans(), kScansPerTask, [&](size_t begin, size_t end) {
    ScanCaster caster(map, scans, hits, surfaces, lone, options, &missing, &num_near);
    for (size_t scan = begin; scan < end; ++scan) caster.cast(scan);
  });
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) {
    missing[leaf] = sufficient(leaf) - static_cast<uint32_t>(std::max(0, static_cast<int32_t>(missing[leaf])));
  }
  return {std::move(missing), std::move(num_near)};
}

}  // namespace cpplus
