#include "cpplus/dynamics/see_through.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "cpplus/core/parallel.h"
#include "cpplus/dynamics/leaf_vote.h"

namespace cpplus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr size_t kScansPerTask = 2;  // they share the working memory, one bit a leaf twice

/// A set of leaves, one bit each.
class LeafSet {
 public:
  explicit LeafSet(size_t num_leaves) : words_((num_leaves + 63) / 64, 0) {}

  bool contains(uint32_t leaf) const { return (words_[leaf / 64] >> (leaf % 64) & 1) != 0; }
  /// False where it was there already.
  bool insert(uint32_t leaf) {
    if (contains(leaf)) return false;
    words_[leaf / 64] |= uint64_t{1} << (leaf % 64);
    members_.push_back(leaf);
    return true;
  }
  const std::vector<uint32_t>& members() const { return members_; }
  /// Takes as long as there are members, whatever the size of the map.
  void clear() {
    for (const uint32_t leaf : members_) words_[leaf / 64] = 0;
    members_.clear();
  }

 private:
  std::vector<uint64_t> words_;
  std::vector<uint32_t> members_;
};

/// Casts the rays of one scan after the other.
class ScanCaster {
 public:
  ScanCaster(const VoxelMap& map, const ScanSet& scans, const LeafSurfaces& surfaces, const DynamicsOptions& options,
             std::vector<uint32_t>* missing)
      : map_(map),
        scans_(scans),
        surfaces_(surfaces),
        options_(options),
        min_sine_(static_cast<float>(std::sin(options.min_grazing_deg * M_PI / 180.0))),
        hit_(surfaces.num_scans.size()),
        passed_(surfaces.num_scans.size()),
        missing_(missing->data()) {}

  /// Takes one from `missing` of each leaf that the scan sees through.
  void cast(size_t scan) {
    hit_.clear();
    passed_.clear();
    cast_rays(scan);
    for (const uint32_t leaf : passed_.members()) {
      if (!hit_.contains(leaf) && !is_beside_hit(leaf)) missing(leaf).fetch_sub(1, std::memory_order_relaxed);
    }
  }

 private:
  void cast_rays(size_t scan) {
    const Vector3d& sensor_in_map = scans_.sensors_in_map[scan];
    const LeafRayCaster caster(map_, sensor_in_map, options_.max_range_m);
    const Vector3f sensor = (sensor_in_map - map_.origin()).cast<float>();
    for (size_t i = scans_.first_point[scan]; i < scans_.first_point[scan + 1]; ++i) {
      const uint32_t leaf = surfaces_.leaf_of_point[i];
      if (leaf == no_voxel || !hit_.insert(leaf)) continue;
      const Vector3f ray = scans_.points.positions[i] - sensor;
      const float range = ray.norm();
      if (range <= 0.0f) continue;
      const Vector3f direction = ray / range;
      const double distance = safe_distance(direction, range, leaf);
      if (distance > 0.0) cast_ray(caster, sensor, direction, distance);
    }
  }

  /// How far the ray to a point of the leaf may be followed: the safe maximum search distance.
  double safe_distance(const Vector3f& direction, float range, uint32_t leaf) const {
    constexpr double kMinSine = 0.01;
    const Vector3f& normal = surfaces_.normals[leaf];
    const bool on_plane = !normal.isZero(0.0f);
    const double sine = std::max(kMinSine, std::abs(static_cast<double>(normal.dot(direction))));
    const double surface_gap = on_plane ? options_.surface_gap_m / sine : options_.range_gap * range;
    const double gap = std::max(options_.min_gap_m, surface_gap);
    return std::min(options_.max_range_m, static_cast<double>(range) - gap);
  }

  void cast_ray(const LeafRayCaster& caster, const Vector3f& sensor, const Vector3f& direction, double distance) {
    const auto end = static_cast<float>(distance);
    const auto max_off2 = static_cast<float>(options_.ray_radius_m * options_.ray_radius_m);
    caster.cast(direction.cast<double>(), distance, [&](uint32_t leaf) {
      if (passed_.contains(leaf) || static_cast<int32_t>(missing(leaf).load(std::memory_order_relaxed)) <= 0) return;
      const Vector3f to_mean = surfaces_.means[leaf] - sensor;
      const float along = to_mean.dot(direction);
      if (along > end || to_mean.squaredNorm() - along * along > max_off2) return;
      const Vector3f& normal = surfaces_.normals[leaf];
      const bool grazes = !normal.isZero(0.0f) && std::abs(normal.dot(direction)) < min_sine_;
      if (!grazes) passed_.insert(leaf);
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

  const VoxelMap& map_;
  const ScanSet& scans_;
  const LeafSurfaces& surfaces_;
  const DynamicsOptions& options_;
  const float min_sine_;
  LeafSet hit_;     // by the scan at hand
  LeafSet passed_;  // by its rays
  uint32_t* missing_;
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
  parallel_for_chunks(scans.num_scans(), kScansPerTask, [&](size_t begin, size_t end) {
    ScanCaster caster(map, scans, surfaces, options, &missing);
    for (size_t scan = begin; scan < end; ++scan) caster.cast(scan);
  });
  for (size_t leaf = 0; leaf < num_leaves; ++leaf) {
    missing[leaf] = sufficient(leaf) - static_cast<uint32_t>(std::max(0, static_cast<int32_t>(missing[leaf])));
  }
  return missing;
}

}  // namespace cpplus
