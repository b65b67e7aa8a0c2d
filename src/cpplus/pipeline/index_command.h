#pragma once

#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/features/map_edges.h"
#include "cpplus/features/plane_segmentation.h"
#include "cpplus/io/index_point_clouds.h"
#include "cpplus/pipeline/feature_store.h"

namespace cpplus {

struct IndexCommandOptions {
  /// Voxel map file to be written (.vox). Required.
  std::string out;
  /// About how much memory to use, MiB. [64, 1048576]
  int memory_mb = 1024;
  /// Finds the planes and edges of the whole map as well; otherwise commands do so where their images are.
  bool features = false;
  VoxelMapOptions voxel_map;
  // Of the features.
  FeatureStoreOptions tiles;
  PlaneSegmentationOptions planes;
  MapEdgeOptions map_edges;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("out", out, "Voxel map file to be written (.vox). Required.");
    visitor("memory_mb", memory_mb, "About how much memory to use, MiB; the time does not depend much on it.");
    visitor("features", features, "Find the planes and edges of the whole map as well, for refine.");
    visitor.group("voxel_map", voxel_map);
    visitor.group("tiles", tiles);
    visitor.group("planes", planes);
    visitor.group("map_edges", map_edges);
  }
};

/// Writes the voxel map of one or several point clouds to a file that other commands take for their map
/// (docs/index.md). Throws Error naming the file for what cannot be read or written; nothing is left behind then.
/// Features of a map that was there before are removed.
IndexSummary index_command(const std::vector<std::string>& maps, const IndexCommandOptions& options);

}  // namespace cpplus
