#include "cpplus/pipeline/tile_features.h"

#include <algorithm>
#include <utility>

#include "cpplus/cloud/map_part.h"
#include "cpplus/cloud/moments.h"
#include "cpplus/cloud/node_range.h"
#include "cpplus/core/memory.h"

namespace cpplus {
namespace {

// Leaves this near to the tile tell which planes of neighbouring tiles are the same, metres.
constexpr double kPatchesAroundM = 0.5;
// The noise is a quantile: this many roots tell it as well as all.
constexpr size_t kMostNoiseRoots = 2048;

/// A root of the tile or around it.
struct PartRoot {
  uint32_t first_leaf_in_map;
  NodeRange leaves;  // of the part
  bool is_own;
};

std::vector<PartRoot> roots_of_part(const VoxelMap& map, const VoxelMap& part, const MapTile& tile,
                                    const std::vector<uint32_t>& roots) {
  std::vector<PartRoot> result;
  result.reserve(roots.size());
  for (uint32_t r = 0; r < roots.size(); ++r) {
    result.push_back({leaves_of(map, 0, roots[r]).begin, leaves_of(part, 0, r),
                      std::binary_search(tile.roots.begin(), tile.roots.end(), roots[r])});
  }
  return result;
}

/// The planes with points in the tile, and their new numbers.
std::vector<int32_t> add_planes(const MapFeatures& found, const std::vector<PartRoot>& roots, TileFeatures* tile) {
  const VoxelMap& part = found.map;
  std::vector<Moments> own;
  for (const MapPlane& plane : found.planes.planes) own.emplace_back(plane.centroid);
  for (const PartRoot& root : roots) {
    if (!root.is_own) continue;
    const uint32_t end = part.points_begin(part.leaf_layer(), root.leaves.end);
    for (uint32_t i = part.points_begin(part.leaf_layer(), root.leaves.begin); i < end; ++i) {
      const int32_t id = found.planes.plane_of_point[i];
      if (id >= 0) own[static_cast<size_t>(id)].add(part.point(i));
      ++tile->num_points;
    }
  }
  std::vector<int32_t> new_id(own.size(), PlaneSegmentation::kNone);
  for (size_t id = 0; id < own.size(); ++id) {
    if (own[id].count() == 0) continue;
    new_id[id] = static_cast<int32_t>(tile->planes.size());
    tile->planes.push_back({found.planes.planes[id], {own[id].count(), own[id].mean(), own[id].covariance()}});
  }
  return new_id;
}

void add_patches(const MapFeatures& found, const std::vector<PartRoot>& roots, const std::vector<int32_t>& new_id,
                 const Eigen::AlignedBox3d& box, TileFeatures* tile) {
  const PlaneSurface& surface = found.surface;
  auto root = roots.begin();
  for (size_t k = 0; k < surface.leaves.size(); ++k) {
    const uint32_t leaf = surface.leaves[k];
    while (leaf >= root->leaves.end) ++root;
    const int32_t plane = new_id[static_cast<size_t>(surface.plane_of[k])];
    if (plane < 0) continue;
    const bool is_near =
        root->is_own || box.exteriorDistance(found.map.center(found.map.leaf_layer(), leaf)) <= kPatchesAroundM;
    if (!is_near) continue;
    const uint32_t leaf_in_map = root->first_leaf_in_map + (leaf - root->leaves.begin);
    (root->is_own ? tile->patches : tile->patches_around).push_back({leaf_in_map, plane, surface.centers[k]});
  }
}

bool touches(const Eigen::AlignedBox3d& box, const MapEdge& edge) {
  const Eigen::Vector3d along = edge.end - edge.start;
  double begin = 0.0;
  double end = 1.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double x = edge.start[axis];
    if (along[axis] == 0.0) {
      if (x < box.min()[axis] || x > box.max()[axis]) return false;
      continue;
    }
    const double to_min = (box.min()[axis] - x) / along[axis];
    const double to_max = (box.max()[axis] - x) / along[axis];
    begin = std::max(begin, std::min(to_min, to_max));
    end = std::min(end, std::max(to_min, to_max));
  }
  return begin <= end;
}

}  // namespace

TileFeatures find_tile_features(const PointMap& points, const MapTile& tile, double halo_m,
                                std::optional<double> noise_m, const RefineImagesOptions& options, Progress* progress) {
  const std::vector<uint32_t> around = roots_around(points.map, tile, halo_m);
  RefineImagesOptions all_planes = options;
  all_planes.visibility.min_plane_points = 0;  // a plane may have more points in other tiles
  const MapFeatures found = extract_map_features(part_of_map(points, around), all_planes, progress, noise_m);
  const std::vector<PartRoot> roots = roots_of_part(points.map, found.map, tile, around);
  TileFeatures result;
  result.noise_m = found.planes.noise_m;
  const std::vector<int32_t> new_id = add_planes(found, roots, &result);
  add_patches(found, roots, new_id, tile.box, &result);
  const Eigen::AlignedBox3d box(tile.box.min().array() - kTileEdgeOverlapM, tile.box.max().array() + kTileEdgeOverlapM);
  for (const MapEdge& edge : found.edges) {
    if (touches(box, edge)) result.edges.push_back(edge);
  }
  for (const PartRoot& root : roots) {
    if (!root.is_own) continue;
    const auto spacing = found.leaf_spacing.begin();
    result.leaf_spacing.insert(result.leaf_spacing.end(), spacing + root.leaves.begin, spacing + root.leaves.end);
  }
  return_freed_memory();
  return result;
}

double sampled_noise_m(const VoxelMap& map, const PlaneSegmentationOptions& options) {
  std::vector<uint32_t> roots;
  const size_t step = (map.num_nodes(0) + kMostNoiseRoots - 1) / kMostNoiseRoots;
  for (size_t root = 0; root < map.num_nodes(0); root += step) roots.push_back(static_cast<uint32_t>(root));
  return range_noise_m(map, roots, options);
}

}  // namespace cpplus
