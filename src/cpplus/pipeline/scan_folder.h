#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/cloud/scan_set.h"
#include "cpplus/geometry/trajectory.h"

namespace cpplus {

/// The scans of a folder in the map frame, and what is needed to name their points in the files again.
struct ScanFolder {
  ScanSet scans;
  Trajectory map_from_lidar;                        // by scan
  std::vector<std::string> files;                   // of the scans, in their order
  std::vector<std::vector<size_t>> dropped_points;  // by scan: non-finite points, by their place in the file
};

/// The point clouds (.pcd .ply .las) right in a folder, sorted by name. Throws Error when `directory` is not a folder
/// or holds none.
std::vector<std::string> list_scans(const std::string& directory);

/// Reads the scans of a folder (LiDAR frame) and moves them into the map frame by the poses of a TUM trajectory
/// (map_from_lidar), pose i for scan i in the order of the names. Intensities, colours and stamps are kept where all
/// scans have them. Throws Error naming the file for what cannot be read, and when there are not as many poses as
/// scans.
ScanFolder read_scan_folder(const std::string& directory, const std::string& poses);

/// Writes DIRECTORY/NAME.label for each scan NAME.EXTENSION: a byte for each point of the file, in its order. Labels
/// are those of the points of folder.scans; a non-finite point gets 0.
void write_label_files(const std::string& directory, const ScanFolder& folder, const std::vector<uint8_t>& labels);

}  // namespace cpplus
