#include "cpplus/adjust/scan_patches.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "cpplus/cloud/moments.h"
#include "cpplus/cloud/voxel_map.h"
#include "cpplus/core/options.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rays that graze a plane measure its distance badly: sine of the least angle between sensor and plane.
constexpr double kMinGrazingSine = 0.07;
constexpr size_t kMinPatchPoints = 30;
constexpr size_t kMinChildPoints = 10;

bool is_planar(double smallest, double second, const PatchOptions& options) {
  return smallest <= options.max_thickness_m * options.max_thickness_m &&
         smallest <= options.max_flatness * options.max_flatness * second;
}

/// The voxels stand askew to the map's axes. Walls and floors mostly lie along these, and one that lay along a face of
/// the voxels would be cut in two by it: points that noise or a wrong pose moves across the face would be missing on
/// one side, and the scan would seem to be where all others are.
Rigid3 grid_from_map(const Vector3d& origin) {
  const Eigen::Matrix3d rotation = so3_exp(Vector3d(0.5, 0.3, 0.4));
  return {rotation, -(rotation * origin)};
}

PointCloud moved_to_grid(const PointCloud& points) {
  const Eigen::Matrix3f rotation = grid_from_map(points.origin).rotation.toRotationMatrix().cast<float>();
  PointCloud in_grid;
  in_grid.positions.resize(points.size());
  constexpr size_t kGrain = 1 << 16;
  parallel_for_chunks(points.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) in_grid.positions[i] = rotation * points.positions[i];
  });
  return in_grid;
}

void move_patch(const Rigid3& map_from_grid, ScanPatch* patch) {
  patch->normal = map_from_grid.rotation * patch->normal;
  for (ScanCluster& cluster : patch->clusters) cluster = moved(cluster, map_from_grid);
}

/// Gathers the patches of the roots [begin, end).
class PatchFinder {
 public:
  PatchFinder(const VoxelMap& map, const std::vector<uint32_t>& scan_of_point, const std::vector<Vector3d>& sensors,
              const PatchOptions& options)
      : map_(map), scan_of_point_(scan_of_point), sensors_(sensors), options_(options) {}

  void descend(int layer, uint32_t node) {
    if (map_.num_points(layer, node) < kMinPatchPoints) return;
    const VoxelStatistics voxel = map_.statistics(layer, node);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(voxel.covariance);
    const Vector3d& values = eigen.eigenvalues();
    if (is_planar(values[0], values[1], options_) && !has_thinner_parts(layer, node, voxel, eigen)) {
      add_patches(layer, node);
      return;
    }
    if (layer + 1 >= map_.leaf_layer()) return;
    const uint32_t end = map_.children_end(layer, node);
    for (uint32_t child = map_.children_begin(layer, node); child < end; ++child) descend(layer + 1, child);
  }

  std::vector<ScanPatch>& patches() { return patches_; }

 private:
  /// Whether planes of the children fit much better than the one of all: an edge, a step, a curved surface.
  bool has_thinner_parts(int layer, uint32_t node, const VoxelStatistics& voxel,
                         const Eigen::SelfAdjointEigenSolver<Matrix3d>& eigen) const {
    const Vector3d normal = eigen.eigenvectors().col(0);
    double whole = 0.0;
    double parts = 0.0;
    const uint32_t end = map_.children_end(layer, node);
    for (uint32_t child = map_.children_begin(layer, node); child < end; ++child) {
      const VoxelStatistics part = map_.statistics(layer + 1, child);
      if (part.count < kMinChildPoints) continue;
      const double n = static_cast<double>(part.count);
      const double offset = normal.dot(part.mean - voxel.mean);
      whole += n * (normal.dot(part.covariance * normal) + offset * offset);
      const Eigen::SelfAdjointEigenSolver<Matrix3d> own(part.covariance, Eigen::EigenvaluesOnly);
      parts += n * own.eigenvalues()[0] * n / (n - 3.0);  // three parameters were fitted
    }
    return parts < options_.split_ratio * whole;
  }

  std::vector<ScanCluster> clusters_of(int layer, uint32_t node) const {
    const uint32_t begin = map_.points_begin(layer, node);
    const uint32_t end = map_.points_end(layer, node);
    std::vector<std::pair<uint32_t, uint32_t>> by_scan;  // scan, point
    by_scan.reserve(end - begin);
    for (uint32_t i = begin; i < end; ++i) by_scan.emplace_back(scan_of_point_[map_.input_index(i)], i);
    std::sort(by_scan.begin(), by_scan.end());
    std::vector<ScanCluster> clusters;
    const Vector3d center = map_.center(layer, node);
    for (size_t first = 0; first < by_scan.size();) {
      Moments moments(center);
      size_t next = first;
      for (; next < by_scan.size() && by_scan[next].first == by_scan[first].first; ++next)
        moments.add(map_.point(by_scan[next].second));
      if (moments.count() >= static_cast<size_t>(options_.min_points)) {
        clusters.push_back(
            {by_scan[first].first, static_cast<double>(moments.count()), moments.mean(), moments.covariance()});
      }
      first = next;
    }
    return clusters;
  }

  void add_patches(int layer, uint32_t node) {
    const std::vector<ScanCluster> clusters = clusters_of(layer, node);
    if (clusters.size() < static_cast<size_t>(options_.min_scans)) return;
    const Vector3d normal = fit(clusters).normal;
    for (const double side : {1.0, -1.0}) {
      ScanPatch patch;
      for (const ScanCluster& cluster : clusters) {
        const Vector3d to_sensor = (sensors_[cluster.scan] - cluster.mean).normalized();
        if (side * normal.dot(to_sensor) > kMinGrazingSine) patch.clusters.push_back(cluster);
      }
      if (patch.clusters.size() < static_cast<size_t>(options_.min_scans)) continue;
      const PatchPlane plane = fit(patch.clusters);
      if (!is_planar(plane.smallest, plane.second, options_)) continue;
      patch.normal = plane.normal;
      patches_.push_back(std::move(patch));
    }
  }

  static PatchPlane fit(const std::vector<ScanCluster>& clusters) {
    std::vector<double> weights;
    for (const ScanCluster& cluster : clusters) weights.push_back(cluster.count);
    return fit_patch_plane(clusters, weights);
  }

  const VoxelMap& map_;
  const std::vector<uint32_t>& scan_of_point_;
  const std::vector<Vector3d>& sensors_;
  const PatchOptions& options_;
  std::vector<ScanPatch> patches_;
};

}  // namespace

void PatchOptions::validate() const {
  check_option(largest_m > 0.0 && std::isfinite(largest_m), "largest_m", "(0, inf)", largest_m);
  check_option(smallest_m > 0.0 && smallest_m <= largest_m, "smallest_m", "(0, largest_m]", smallest_m);
  const double layers = std::log2(largest_m / smallest_m);
  check_option(layers <= 8.0 && std::abs(layers - std::round(layers)) < 1e-9, "largest_m / smallest_m",
               "a power of two up to 256", largest_m / smallest_m);
  check_option(min_scans >= 2, "min_scans", "[2, inf)", min_scans);
  check_option(min_points >= 1, "min_points", "[1, inf)", min_points);
  check_option(max_thickness_m > 0.0, "max_thickness_m", "(0, inf)", max_thickness_m);
  check_option(max_flatness > 0.0 && max_flatness < 1.0, "max_flatness", "(0, 1)", max_flatness);
  check_option(split_ratio > 0.0 && split_ratio <= 1.0, "split_ratio", "(0, 1]", split_ratio);
}

PatchPlane fit_patch_plane(const std::vector<ScanCluster>& clusters, const std::vector<double>& weights) {
  const Vector3d reference = clusters.front().mean;
  double sum = 0.0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (size_t k = 0; k < clusters.size(); ++k) {
    const Vector3d d = clusters[k].mean - reference;
    sum += weights[k];
    first += weights[k] * d;
    second += weights[k] * (clusters[k].covariance + d * d.transpose());
  }
  first /= sum;
  second = second / sum - first * first.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(second);
  const Vector3d& values = eigen.eigenvalues();
  return {eigen.eigenvectors().col(0), reference + first, std::max(values[0], 0.0), std::max(values[1], 0.0)};
}

ScanCluster moved(const ScanCluster& cluster, const Rigid3& new_map_from_map) {
  const Matrix3d rotation = new_map_from_map.rotation.toRotationMatrix();
  return {cluster.scan, cluster.count, new_map_from_map * cluster.mean,
          rotation * cluster.covariance * rotation.transpose()};
}

std::vector<ScanPatch> find_scan_patches(const PointCloud& points, const std::vector<uint32_t>& scan_of_point,
                                         const std::vector<Vector3d>& sensors, const PatchOptions& options) {
  const Rigid3 map_from_grid = inverse(grid_from_map(points.origin));
  const VoxelMap map(moved_to_grid(points), {options.largest_m, options.smallest_m / 2.0});
  std::vector<Vector3d> sensors_in_grid;
  for (const Vector3d& sensor : sensors) sensors_in_grid.push_back(grid_from_map(points.origin) * sensor);
  constexpr size_t kGrain = 8;
  const size_t num_roots = map.num_nodes(0);
  std::vector<std::vector<ScanPatch>> chunks((num_roots + kGrain - 1) / kGrain);
  parallel_for_chunks(num_roots, kGrain, [&](size_t begin, size_t end) {
    PatchFinder finder(map, scan_of_point, sensors_in_grid, options);
    for (size_t root = begin; root < end; ++root) finder.descend(0, static_cast<uint32_t>(root));
    for (ScanPatch& patch : finder.patches()) move_patch(map_from_grid, &patch);
    chunks[begin / kGrain] = std::move(finder.patches());
  });
  std::vector<ScanPatch> patches;
  for (std::vector<ScanPatch>& chunk : chunks) std::move(chunk.begin(), chunk.end(), std::back_inserter(patches));
  return patches;
}

double range_noise(const std::vector<ScanPatch>& patches) {
  constexpr double kManyPoints = 10.0;
  std::vector<double> variances;
  for (const ScanPatch& patch : patches) {
    for (const ScanCluster& cluster : patch.clusters) {
      if (cluster.count >= kManyPoints) variances.push_back(patch.normal.dot(cluster.covariance * patch.normal));
    }
  }
  if (variances.empty()) return 0.0;
  const auto middle = variances.begin() + static_cast<ptrdiff_t>(variances.size() / 2);
  std::nth_element(variances.begin(), middle, variances.end());
  return std::sqrt(std::max(*middle, 0.0));
}

}  // namespace cpplus
