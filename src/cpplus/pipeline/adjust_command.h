#pragma once

#include <string>

#include "cpplus/adjust/adjust_scans.h"

namespace cpplus {

struct AdjustCommandOptions {
  /// Folder of the scans (.pcd .ply .las), in the LiDAR frame. Required.
  std::string scans;
  /// TUM trajectory, map_from_lidar: a line for each scan in the order of the names. Required.
  std::string poses;
  /// TUM trajectory to be written; a report goes beside it, with the extension .json. Required.
  std::string out;
  /// Map of all points by these poses, to be written (.pcd .ply .las); "" = none.
  std::string map;
  AdjustOptions adjust;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("scans", scans, "Folder of the scans (.pcd .ply .las), in the LiDAR frame. Required.");
    visitor("poses", poses,
            "TUM trajectory, map_from_lidar: a line for each scan in the order of the names. Required.");
    visitor("out", out, "TUM trajectory to be written; a report goes beside it, with the extension .json. Required.");
    visitor("map", map, "Map of all points by these poses, to be written (.pcd .ply .las); empty = none.");
    visitor.group("adjust", adjust);
  }
};

/// Reads the scans, adjusts their poses, and writes these, the report, and the map where it is asked for. Throws Error
/// naming the file for anything that cannot be read or written, and when scans and poses differ in number.
AdjustResult run_adjust(const AdjustCommandOptions& options);

/// Where the report of a trajectory goes.
std::string adjust_report_path(const std::string& out);

}  // namespace cpplus
