#include "cpplus/pipeline/join_tile_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "cpplus/cloud/moments.h"

namespace cpplus {
namespace {

// Two patches of a leaf hold the same points, by and large, where their means are this near, in sigmas of the noise.
constexpr double kSamePatchSigmas = 1.5;
// Share of the leaves that a plane has beyond a border in which the other tile's plane is the same.
constexpr double kMinSameShare = 0.5;
constexpr int kMinSameLeaves = 2;
// One plane fits the points of two where they lie this near to it, as a multiple of the RMS distance of either or the
// noise: as far as growing planes reach for points.
constexpr double kMaxThickening = 1.5;

/// A patch in the tile that holds its leaf.
struct OwnPatch {
  uint32_t leaf;
  int32_t plane;  // over all tiles
  Eigen::Vector3f center;
};

/// Planes of two tiles that share leaves.
struct Link {
  int32_t a, b;
  int num_same;
};

class PlaneJoiner {
 public:
  explicit PlaneJoiner(const std::vector<TileFeatures>& tiles) : tiles_(tiles) {
    for (const TileFeatures& tile : tiles) {
      first_.push_back(static_cast<int32_t>(planes_.size()));
      for (const TilePlane& plane : tile.planes) planes_.push_back(&plane);
    }
    parent_.resize(planes_.size());
    std::iota(parent_.begin(), parent_.end(), 0);
    for (const TilePlane* plane : planes_) {
      points_.emplace_back(plane->plane.centroid);
      points_.back().add(plane->own);
    }
  }

  JoinedPlanes run() {
    JoinedPlanes joined;
    joined.noise_m = noise_m_ = mean_noise_m();
    for (const Link& link : find_links()) join(link);
    const std::vector<const MapPlane*> widest = widest_fits();
    std::vector<int32_t> number(planes_.size(), -1);
    for (size_t t = 0; t < tiles_.size(); ++t) {
      joined.number_of.emplace_back();
      for (size_t p = 0; p < tiles_[t].planes.size(); ++p) {
        const auto root = static_cast<size_t>(find(first_[t] + static_cast<int32_t>(p)));
        if (number[root] < 0) {
          number[root] = static_cast<int32_t>(joined.planes.size());
          joined.planes.push_back(plane_of(points_[root], *widest[root]));
        }
        joined.number_of.back().push_back(number[root]);
      }
    }
    return joined;
  }

 private:
  /// About the first one, so that the mean of one is itself.
  double mean_noise_m() const {
    if (tiles_.empty()) return 0.0;
    double sum = 0.0;
    double weight = 0.0;
    for (const TileFeatures& tile : tiles_) {
      sum += static_cast<double>(tile.num_points) * (tile.noise_m - tiles_[0].noise_m);
      weight += static_cast<double>(tile.num_points);
    }
    return tiles_[0].noise_m + (weight > 0.0 ? sum / weight : 0.0);
  }

  int32_t find(int32_t id) const {
    while (parent_[static_cast<size_t>(id)] != id) id = parent_[static_cast<size_t>(id)];
    return id;
  }

  /// The leaves that tiles have patches around them in, ascending.
  std::vector<uint32_t> leaves_around() const {
    std::vector<uint32_t> leaves;
    for (const TileFeatures& tile : tiles_) {
      for (const PlanePatch& patch : tile.patches_around) leaves.push_back(patch.leaf);
    }
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    return leaves;
  }

  /// The patches of these leaves in the tiles that hold them, in the order of the leaves: of all patches few.
  std::vector<OwnPatch> own_patches(const std::vector<uint32_t>& leaves) const {
    std::vector<OwnPatch> own;
    for (size_t t = 0; t < tiles_.size(); ++t) {
      auto leaf = leaves.begin();
      for (const PlanePatch& patch : tiles_[t].patches) {
        while (leaf != leaves.end() && *leaf < patch.leaf) ++leaf;
        if (leaf == leaves.end()) break;
        if (*leaf == patch.leaf) own.push_back({patch.leaf, first_[t] + patch.plane, patch.center});
      }
    }
    std::stable_sort(own.begin(), own.end(), [](const auto& a, const auto& b) { return a.leaf < b.leaf; });
    return own;
  }

  /// Planes that are the same in most of the leaves that one has in the other's tile; those that share most first.
  std::vector<Link> find_links() const {
    const std::vector<OwnPatch> own = own_patches(leaves_around());
    std::map<std::pair<int32_t, int32_t>, int> num_same;
    std::map<std::pair<int32_t, size_t>, int> num_around;  // leaves of a plane in the patches of another tile
    const auto is_before = [](const OwnPatch& patch, uint32_t leaf) { return patch.leaf < leaf; };
    for (size_t t = 0; t < tiles_.size(); ++t) {
      for (const PlanePatch& around : tiles_[t].patches_around) {
        const auto begin = std::lower_bound(own.begin(), own.end(), around.leaf, is_before);
        const int32_t plane = first_[t] + around.plane;
        double nearest_m = kSamePatchSigmas * noise_m_;
        int32_t same = PlaneSegmentation::kNone;
        for (auto it = begin; it != own.end() && it->leaf == around.leaf; ++it) {
          const double distance_m = static_cast<double>((it->center - around.center).norm());
          if (distance_m > nearest_m) continue;
          nearest_m = distance_m;
          same = it->plane;
        }
        if (begin == own.end() || begin->leaf != around.leaf) continue;  // in none of these tiles
        ++num_around[{plane, tile_of(begin->plane)}];
        if (same >= 0) ++num_same[{plane, same}];
      }
    }
    std::vector<Link> links;
    for (const auto& [pair, count] : num_same) {
      const int around = num_around[{pair.first, tile_of(pair.second)}];
      if (count >= kMinSameLeaves && count >= kMinSameShare * around) links.push_back({pair.first, pair.second, count});
    }
    std::stable_sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.num_same > b.num_same; });
    return links;
  }

  size_t tile_of(int32_t plane) const {
    return static_cast<size_t>(std::upper_bound(first_.begin(), first_.end(), plane) - first_.begin() - 1);
  }

  static double thickness_m(const Moments& points) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(points.covariance(), Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, eigen.eigenvalues()(0)));
  }

  void join(const Link& link) {
    const int32_t a = find(link.a);
    const int32_t b = find(link.b);
    if (a == b) return;
    Moments& points_a = points_[static_cast<size_t>(std::min(a, b))];
    const Moments& points_b = points_[static_cast<size_t>(std::max(a, b))];
    Moments both = points_a;
    both.add(VoxelStatistics{points_b.count(), points_b.mean(), points_b.covariance()});
    const double most_m = kMaxThickening * std::max({noise_m_, thickness_m(points_a), thickness_m(points_b)});
    if (thickness_m(both) > most_m) return;
    points_a = both;
    parent_[static_cast<size_t>(std::max(a, b))] = std::min(a, b);
  }

  /// Of the tiles' fits of each joined plane the one with most points; by the first plane.
  std::vector<const MapPlane*> widest_fits() const {
    std::vector<const MapPlane*> widest(planes_.size(), nullptr);
    for (size_t id = 0; id < planes_.size(); ++id) {
      const MapPlane*& fit = widest[static_cast<size_t>(find(static_cast<int32_t>(id)))];
      if (fit == nullptr || planes_[id]->plane.num_points > fit->num_points) fit = &planes_[id]->plane;
    }
    return widest;
  }

  /// Fitted to the points of all tiles, unless a tile with what is around it has seen more of the plane.
  static MapPlane plane_of(const Moments& points, const MapPlane& widest) {
    if (points.count() <= widest.num_points) return widest;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(points.covariance());
    return {eigen.eigenvectors().col(0), points.mean(), std::sqrt(std::max(0.0, eigen.eigenvalues()(0))),
            static_cast<uint32_t>(points.count())};
  }

  const std::vector<TileFeatures>& tiles_;
  std::vector<int32_t> first_;  // number of each tile's first plane over all tiles
  std::vector<const TilePlane*> planes_;
  std::vector<int32_t> parent_;
  std::vector<Moments> points_;  // of the planes that are one, in the tiles; by their first
  double noise_m_ = 0.0;
};

}  // namespace

JoinedPlanes join_tile_planes(const std::vector<TileFeatures>& tiles) { return PlaneJoiner(tiles).run(); }

}  // namespace cpplus
