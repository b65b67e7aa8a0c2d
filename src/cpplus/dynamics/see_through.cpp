#include "cpplus/dynamics/see_through.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>

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

/// Finds what the scans see through, one scan after the other.
class ScanCaster {
 public:
  ScanCaster(const VoxelMap& map, const ScanSet& scans, const ScanHits& hits, const LeafSurfaces& surfaces,
             const DynamicsOptions& options, std::vector<uint32_t>* missing)
      : map_(map),
        scans_(scans),
        hits_(hits),
        surfaces_(surfaces),
        options_(options),
        max_range_(static_cast<float>(options.max_range_m)),
        radius_(static_cast<float>(options.ray_radius_m)),
        max_off2_(radius_ * radius_),
        min_sine_(static_cast<float>(std::sin(options.min_grazing_deg * M_PI / 180.0))),
        missing_(missing->data()),
        hit_(surfaces.num_scans.size()) {}

  /// Takes one from `missing` of each leaf that the scan sees through.
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
    const float nearest = cube.distance();
    if (nearest > max_range_ || grid_.reach(cube) < nearest) return;
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
    if (static_cast<int32_t>(missing(leaf).load(std::memory_order_relaxed)) <= 0 || hit_.contains(leaf)) return;
    const Vector3f to_mean = surfaces_.means[leaf] - sensor_;
    const float range2 = to_mean.squaredNorm();
    const float shortest = std::sqrt(std::max(0.0f, range2 - max_off2_));
    const Vector3f& normal = surfaces_.normals[leaf];
    const float min_sine = normal.isZero(0.0f) ? 0.0f : min_sine_;
    // Whatever passes the mean within the radius grazes then: most of the ground goes here.
    if (std::abs(normal.dot(to_mean)) + radius_ < min_sine * shortest) return;
    if (grid_.reach(cube) < shortest) return;
    const bool passed = grid_.any_ray(cube, [&](const ScanRay& ray) {
      if (ray.length_m < shortest) return false;
      const float along = to_mean.dot(ray.direction);
      return along <= ray.length_m && along > 0.0f && range2 - along * along <= max_off2_ &&
             std::abs(normal.dot(ray.direction)) >= min_sine && line_meets(ray.direction, cube);
    });
    if (passed && !is_beside_hit(leaf)) missing(leaf).fetch_sub(1, std::memory_order_relaxed);
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

  const VoxelMap& map_;
  const ScanSet& scans_;
  const ScanHits& hits_;
  const LeafSurfaces& surfaces_;
  const DynamicsOptions& options_;
  const float max_range_;
  const float radius_;
  const float max_off2_;
  const float min_sine_;
  uint32_t* missing_;
  // Of the scan at hand:
  Vector3f sensor_;  // relative to the map's origin
  LeafSet hit_;
  std::vector<ScanRay> rays_;
  RayGrid grid_;
  std::vector<uint32_t> neighbors_;
};

}  // namespace

std::vector<uint32_t> count_see_through(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces,
                                        const DynamicsOptions& options) {
  const size_t num_leaves = surfaces.num_scans.size();
  std::vector<uint32_t> missing(num_leaves);
  const auto sufficient = [&](size_t leaf) {
    return sufficient_scans(surfaces.num_scans[leaf], scans.num_scans(), options);
  };
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) missing[leaf] = sufficient(leaf);
  const ScanHits hits = find_scan_hits(map, scans);
  parallel_for_chunks(scans.num_scans(), kScansPerTask, [&](size_t begin, size_t end) {
    ScanCaster caster(map, scans, hits, surfaces, options, &missing);
    for (size_t scan = begin; scan < end; ++scan) caster.cast(scan);
  });
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) {
    missing[leaf] = sufficient(leaf) - static_cast<uint32_t>(std::max(0, static_cast<int32_t>(missing[leaf])));
  }
  return missing;
}

}  // namespace cpplus
