#include "cpplus/features/plane_segmentation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cpplus/cloud/moments.h"
#include "cpplus/core/parallel.h"
#include "cpplus/features/leaf_neighbors.h"
#include "cpplus/features/settle_points.h"

namespace cpplus {
namespace {

struct Seed {
  int layer;
  uint32_t node;
};

// The surface around a leaf (its own points and those of its neighbours).
struct LeafSurface {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  bool planar = false;
};

constexpr double kMinSigma = 0.004;  // keeps noise-free maps from rejecting their own rounding

bool is_planar(const Moments& moments, const PlaneSegmentationOptions& options, Eigen::Vector3d* normal,
               double* thickness) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments.covariance());
  *normal = eigen.eigenvectors().col(0);
  *thickness = std::sqrt(std::max(0.0, eigen.eigenvalues()(0)));
  return *thickness < options.max_thickness_m &&
         eigen.eigenvalues()(0) < options.max_eigenvalue_ratio * eigen.eigenvalues()(1);
}

// The planar voxels in a node, by layer, none of them in another.
void collect_seeds(const VoxelMap& map, const PlaneSegmentationOptions& options, int layer, uint32_t node,
                   std::vector<std::vector<Seed>>* seeds) {
  const VoxelStatistics statistics = map.statistics(layer, node);
  if (statistics.count < static_cast<size_t>(options.min_seed_points)) return;
  Moments moments(statistics.mean);
  moments.add(statistics);
  Eigen::Vector3d normal;
  double thickness = 0.0;
  if (is_planar(moments, options, &normal, &thickness)) {
    (*seeds)[static_cast<size_t>(layer)].push_back({layer, node});
    return;
  }
  if (layer == map.leaf_layer()) return;
  for (uint32_t child = map.children_begin(layer, node); child < map.children_end(layer, node); ++child) {
    collect_seeds(map, options, layer + 1, child, seeds);
  }
}

// The range noise of the map: most planar voxels hold one surface, relief and double walls only add thickness, so a
// low quantile is the noise itself. It bounds how far a plane may reach for points; a bound that followed the
// plane's own spread would let skirting boards, frames and recesses join the wall one after the other.
double noise_of(const VoxelMap& map, const PlaneSegmentationOptions& options,
                const std::vector<std::vector<Seed>>& seeds) {
  std::vector<double> thickness;
  for (const std::vector<Seed>& layer : seeds) {
    for (const Seed& seed : layer) {
      const VoxelStatistics statistics = map.statistics(seed.layer, seed.node);
      if (statistics.count < 30) continue;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(statistics.covariance, Eigen::EigenvaluesOnly);
      thickness.push_back(std::sqrt(std::max(0.0, eigen.eigenvalues()(0))));
    }
  }
  double noise = 0.5 * options.max_thickness_m;
  if (!thickness.empty()) {
    const auto middle = thickness.begin() + static_cast<std::ptrdiff_t>(thickness.size() * 2 / 5);
    std::nth_element(thickness.begin(), middle, thickness.end());
    noise = *middle;
  }
  return std::clamp(noise, kMinSigma, options.max_thickness_m);
}

class PlaneGrower {
 public:
  PlaneGrower(const VoxelMap& map, const PlaneSegmentationOptions& options)
      : map_(map),
        options_(options),
        neighbors_(map),
        min_cos_(std::cos(options.max_angle_deg * std::numbers::pi / 180.0)) {
    result_.plane_of_point.assign(map.num_points(), PlaneSegmentation::kNone);
    visited_by_.assign(map.num_nodes(map.leaf_layer()), -1);
    collect_surfaces();
  }

  PlaneSegmentation run(std::optional<double> noise_m) {
    // Coarse to fine: large planar voxels have the best-known normals, so they claim their surroundings first.
    std::vector<std::vector<Seed>> seeds(static_cast<size_t>(map_.num_layers()));
    for (uint32_t root = 0; root < map_.num_nodes(0); ++root) collect_seeds(map_, options_, 0, root, &seeds);
    noise_ = noise_m.value_or(noise_of(map_, options_, seeds));
    result_.noise_m = noise_;
    for (const std::vector<Seed>& layer : seeds) {
      for (const Seed& seed : layer) grow(seed);
    }
    settle_points(map_, neighbors_, {options_.max_distance_sigmas, options_.min_plane_points}, &result_);
    return std::move(result_);
  }

 private:
  void collect_surfaces() {
    const int leaf_layer = map_.leaf_layer();
    const uint32_t num_leaves = map_.num_nodes(leaf_layer);
    surfaces_.resize(num_leaves);
    parallel_for_chunks(num_leaves, 4096, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const uint32_t leaf = static_cast<uint32_t>(i);
        Moments moments(map_.center(leaf_layer, leaf));
        moments.add(map_.statistics(leaf_layer, leaf));
        for (const uint32_t neighbor : neighbors_[leaf]) moments.add(map_.statistics(leaf_layer, neighbor));
        if (moments.count() < 8) continue;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments.covariance());
        // Three times looser than a seed: a few noisy points must only not contradict the plane.
        surfaces_[leaf].planar = eigen.eigenvalues()(0) < 3.0 * options_.max_eigenvalue_ratio * eigen.eigenvalues()(1);
        surfaces_[leaf].normal = eigen.eigenvectors().col(0).cast<float>();
      }
    });
  }

  bool is_free(uint32_t point) const { return result_.plane_of_point[point] == PlaneSegmentation::kNone; }

  void grow(const Seed& seed) {
    const Eigen::Vector3d seed_center = map_.center(seed.layer, seed.node);
    Moments moments(seed_center);
    for (uint32_t i = map_.points_begin(seed.layer, seed.node); i < map_.points_end(seed.layer, seed.node); ++i) {
      if (is_free(i)) moments.add(map_.point(i));
    }
    if (moments.count() < static_cast<size_t>(options_.min_seed_points)) return;
    MapPlane plane;
    if (!is_planar(moments, options_, &plane.normal, &plane.sigma_m)) return;
    plane.centroid = moments.mean();

    const int32_t id = static_cast<int32_t>(result_.planes.size());
    frontier_.clear();
    uint32_t leaf_begin = seed.node;
    uint32_t leaf_end = seed.node + 1;
    for (int layer = seed.layer; layer < map_.leaf_layer(); ++layer) {
      leaf_begin = map_.children_begin(layer, leaf_begin);
      leaf_end = map_.children_begin(layer, leaf_end);
    }
    for (uint32_t leaf = leaf_begin; leaf < leaf_end; ++leaf) push(leaf, id);

    Moments grown(seed_center);
    std::vector<uint32_t> points;
    std::vector<uint32_t> leaves;
    size_t next_fit = moments.count() * 2;
    for (size_t next = 0; next < frontier_.size(); ++next) {
      const uint32_t leaf = frontier_[next];
      if (!claim(leaf, plane, id, &grown, &points)) continue;
      leaves.push_back(leaf);
      for (const uint32_t neighbor : neighbors_[leaf]) push(neighbor, id);
      if (grown.count() >= next_fit) {
        next_fit = grown.count() + grown.count() / 2;
        fit(grown, &plane);
      }
    }
    finish(grown, points, std::move(leaves), plane);
  }

  void push(uint32_t leaf, int32_t id) {
    if (visited_by_[leaf] == id) return;
    visited_by_[leaf] = id;
    frontier_.push_back(leaf);
  }

  // Gives the plane the leaf's free points that lie on it. False when the leaf does not belong to it.
  bool claim(uint32_t leaf, const MapPlane& plane, int32_t id, Moments* grown, std::vector<uint32_t>* points) {
    const LeafSurface& surface = surfaces_[leaf];
    if (surface.planar && std::abs(surface.normal.cast<double>().dot(plane.normal)) < min_cos_) return false;
    const double max_distance = options_.max_distance_sigmas * std::clamp(plane.sigma_m, noise_, 1.5 * noise_);
    const size_t before = points->size();
    const int leaf_layer = map_.leaf_layer();
    for (uint32_t i = map_.points_begin(leaf_layer, leaf); i < map_.points_end(leaf_layer, leaf); ++i) {
      if (!is_free(i)) continue;
      const Eigen::Vector3d x = map_.point(i);
      if (std::abs(plane.signed_distance(x)) > max_distance) continue;
      result_.plane_of_point[i] = id;
      points->push_back(i);
      grown->add(x);
    }
    return points->size() > before;
  }

  void fit(const Moments& moments, MapPlane* plane) const {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments.covariance());
    plane->normal = eigen.eigenvectors().col(0);
    plane->centroid = moments.mean();
    plane->sigma_m = std::sqrt(std::max(0.0, eigen.eigenvalues()(0)));
    plane->num_points = static_cast<uint32_t>(moments.count());
  }

  void finish(const Moments& grown, const std::vector<uint32_t>& points, std::vector<uint32_t>&& leaves,
              MapPlane plane) {
    const bool keep = grown.count() >= static_cast<size_t>(options_.min_plane_points);
    if (keep) fit(grown, &plane);
    if (!keep || plane.sigma_m > options_.max_thickness_m) {
      for (const uint32_t point : points) result_.plane_of_point[point] = PlaneSegmentation::kNone;
      // The id is used again; leaves this plane visited must look unvisited to the next.
      for (const uint32_t leaf : frontier_) visited_by_[leaf] = -1;
      return;
    }
    std::sort(leaves.begin(), leaves.end());
    result_.planes.push_back(plane);
    result_.leaves.push_back(std::move(leaves));
  }

  const VoxelMap& map_;
  const PlaneSegmentationOptions& options_;
  LeafNeighbors neighbors_;
  double min_cos_;
  double noise_ = 0.0;
  PlaneSegmentation result_;
  std::vector<LeafSurface> surfaces_;
  std::vector<int32_t> visited_by_;
  std::vector<uint32_t> frontier_;
};

}  // namespace

void PlaneSegmentationOptions::validate() const {
  check_option(max_eigenvalue_ratio > 0 && max_eigenvalue_ratio < 1, "max_eigenvalue_ratio", "(0, 1)",
               max_eigenvalue_ratio);
  check_option(max_thickness_m > 0, "max_thickness_m", "(0, inf)", max_thickness_m);
  check_option(min_seed_points >= 4, "min_seed_points", "[4, inf)", min_seed_points);
  check_option(min_plane_points >= 4, "min_plane_points", "[4, inf)", min_plane_points);
  check_option(max_distance_sigmas > 0, "max_distance_sigmas", "(0, inf)", max_distance_sigmas);
  check_option(max_angle_deg > 0 && max_angle_deg < 90, "max_angle_deg", "(0, 90)", max_angle_deg);
}

PlaneSegmentation segment_planes(const VoxelMap& map, const PlaneSegmentationOptions& options,
                                 std::optional<double> noise_m) {
  options.validate();
  if (map.num_points() == 0) return {};
  return PlaneGrower(map, options).run(noise_m);
}

double range_noise_m(const VoxelMap& map, std::span<const uint32_t> roots, const PlaneSegmentationOptions& options) {
  options.validate();
  std::vector<std::vector<Seed>> seeds(static_cast<size_t>(map.num_layers()));
  for (const uint32_t root : roots) collect_seeds(map, options, 0, root, &seeds);
  return noise_of(map, options, seeds);
}

}  // namespace cpplus
