#pragma once

#include <string>
#include <vector>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/io/index_point_clouds.h"

namespace cpplus {

struct IndexCommandOptions {
  /// Voxel map file to be written (.vox). Required.
  std::string out;
  /// About how much memory to use, MiB. [64, 1048576]
  int memory_mb = 1024;
  VoxelMapOptions voxel_map;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("out", out, "Voxel map file to be written (.vox). Required.");
    visitor("memory_mb", memory_mb, "About how much memory to use, MiB; the time does not depend much on it.");
    visitor.group("voxel_map", voxel_map);
  }
};

/// Writes the voxel map of one or several point clouds to a file that other commands take for their map
/// (docs/index.md). Throws Error naming the file for what cannot be read or written; nothing is left behind then.
IndexSummary index_command(const std::vector<std::string>& maps, const IndexCommandOptions& options);

}  // namespace cpplus
