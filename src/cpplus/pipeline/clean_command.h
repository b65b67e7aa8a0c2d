#pragma once

#include <cstddef>
#include <string>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/dynamics/find_dynamics.h"

namespace cpplus {

struct CleanCommandOptions {
  /// Folder of the scans (.pcd .ply .las), in the LiDAR frame. Required.
  std::string scans;
  /// TUM trajectory, map_from_lidar: a line for each scan in the order of the names. Required.
  std::string poses;
  /// Map of the static points to be written; the extension gives the format. Required.
  std::string out;
  /// Folder for NAME.label of each scan: a byte a point, 0 static, 1 dynamic; "" = none.
  std::string labels;
  VoxelMapOptions voxel_map;
  DynamicsOptions dynamics;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("scans", scans, "Folder of the scans (.pcd .ply .las), in the LiDAR frame. Required.");
    visitor("poses", poses,
            "TUM trajectory, map_from_lidar: a line for each scan in the order of the names. Required.");
    visitor("out", out, "Map of the static points to be written (.pcd .ply .las). Required.");
    visitor("labels", labels, "Folder for NAME.label of each scan: a byte a point, 0 static, 1 dynamic; empty = none.");
    visitor.group("voxel_map", voxel_map);
    visitor.group("dynamics", dynamics);
  }
};

struct CleanSummary {
  size_t num_scans = 0;
  size_t num_points = 0;  // finite ones
  size_t num_dynamic = 0;
};

/// Reads the scans, finds what moved, and writes the map of all other points, not thinned, in the order of the scans.
/// Throws Error naming the file for anything that cannot be read or written, when scans and poses differ in number, and
/// where nothing is static; no map is written then.
CleanSummary run_clean(const CleanCommandOptions& options);

}  // namespace cpplus
