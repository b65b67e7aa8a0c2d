#include "cpplus/pipeline/join_tiles.h"

#include <algorithm>
#include <utility>

#include "cpplus/cloud/node_range.h"
#include "cpplus/pipeline/join_tile_edges.h"
#include "cpplus/pipeline/join_tile_planes.h"

namespace cpplus {
namespace {

/// A root that is looked at.
struct NearRoot {
  NodeRange leaves;         // of the map
  uint32_t first_leaf = 0;  // of the map of these roots
  size_t tile = 0;
  size_t first_spacing = 0;  // in the tile's
};

std::vector<NearRoot> find_near_roots(const VoxelMap& map, const std::vector<uint32_t>& roots,
                                      const std::vector<const MapTile*>& tiles) {
  std::vector<NearRoot> near(roots.size());
  for (size_t t = 0; t < tiles.size(); ++t) {
    size_t first_spacing = 0;
    for (const uint32_t root : tiles[t]->roots) {
      const NodeRange leaves = leaves_of(map, 0, root);
      const auto it = std::lower_bound(roots.begin(), roots.end(), root);
      if (it != roots.end() && *it == root) {
        near[static_cast<size_t>(it - roots.begin())] = {leaves, 0, t, first_spacing};
      }
      first_spacing += leaves.size();
    }
  }
  uint32_t num_leaves = 0;
  for (NearRoot& root : near) {
    root.first_leaf = num_leaves;
    num_leaves += root.leaves.size();
  }
  return near;
}

/// Planes without patches are dropped; those with few points have none in the surface.
void add_planes(const JoinedPlanes& joined, const std::vector<NearRoot>& roots,
                const std::vector<TileFeatures>& features, uint32_t min_points, MapFeatures* result) {
  std::vector<int32_t> number(joined.planes.size(), PlaneSegmentation::kNone);
  PlaneSurface& surface = result->surface;
  std::vector<char> is_seen(joined.planes.size(), 0);
  for (const NearRoot& root : roots) {
    const std::vector<PlanePatch>& patches = features[root.tile].patches;
    const auto is_before = [](const PlanePatch& patch, uint32_t leaf) { return patch.leaf < leaf; };
    auto patch = std::lower_bound(patches.begin(), patches.end(), root.leaves.begin, is_before);
    for (; patch != patches.end() && patch->leaf < root.leaves.end; ++patch) {
      const int32_t plane = joined.number_of[root.tile][static_cast<size_t>(patch->plane)];
      is_seen[static_cast<size_t>(plane)] = 1;
      if (joined.planes[static_cast<size_t>(plane)].num_points < min_points) continue;
      surface.leaves.push_back(patch->leaf - root.leaves.begin + root.first_leaf);
      surface.plane_of.push_back(plane);
      surface.centers.push_back(patch->center);
    }
  }
  for (size_t id = 0; id < joined.planes.size(); ++id) {
    if (is_seen[id] == 0) continue;
    number[id] = static_cast<int32_t>(result->planes.planes.size());
    result->planes.planes.push_back(joined.planes[id]);
  }
  for (int32_t& plane : surface.plane_of) plane = number[static_cast<size_t>(plane)];
}

}  // namespace

MapFeatures join_tiles(const VoxelMap& map, const VoxelMap& near, const std::vector<uint32_t>& roots,
                       const std::vector<const MapTile*>& tiles, const std::vector<TileFeatures>& features,
                       const RefineImagesOptions& options) {
  MapFeatures result;
  result.map = near;
  const std::vector<NearRoot> near_roots = find_near_roots(map, roots, tiles);
  const JoinedPlanes joined = join_tile_planes(features);
  result.planes.noise_m = joined.noise_m;
  add_planes(joined, near_roots, features, static_cast<uint32_t>(options.visibility.min_plane_points), &result);
  result.edges = join_tile_edges(tiles, features);
  for (const NearRoot& root : near_roots) {
    const auto spacing = features[root.tile].leaf_spacing.begin() + static_cast<std::ptrdiff_t>(root.first_spacing);
    result.leaf_spacing.insert(result.leaf_spacing.end(), spacing, spacing + root.leaves.size());
  }
  return result;
}

}  // namespace cpplus
