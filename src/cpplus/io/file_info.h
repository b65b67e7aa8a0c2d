#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cpplus/io/image_io.h"

namespace cpplus {

enum class FileKind { kUnknown, kPointCloud, kSparseModel, kTrajectory, kStamps, kImage, kFolder };

/// What a file or folder is and says about itself, found without reading the points of a cloud.
struct FileInfo {
  FileKind kind = FileKind::kUnknown;
  std::string format;  // e.g. "PCD binary", "LAS 1.4, point format 3", "COLMAP text"
  /// Points of a cloud, images of a model, poses of a trajectory, stamps, files in a folder.
  uint64_t count = 0;
  std::vector<std::string> fields;            // of a point cloud, in the order of the file
  std::optional<Eigen::AlignedBox3d> extent;  // metres; LAS only, as its header announces it
  ImageSize image_size;                       // of an image
  std::vector<std::string> cameras;           // of a model, e.g. "1: OPENCV 1024 x 768"
  uint64_t num_sparse_points = 0;             // of a model
  double first_stamp_s = 0.0;                 // of a trajectory or stamps
  double last_stamp_s = 0.0;
  uint64_t num_images = 0;  // files of a folder that look like images, subfolders included
  uint64_t num_clouds = 0;  // ... like point clouds
};

/// Throws Error for a path that does not exist, and for a file that is broken as what its name or beginning says it is.
/// A file that is nothing known is kUnknown.
FileInfo inspect_file(const std::string& path);

/// Paths of the image files under the folder, relative to it with '/' between, sorted. By extension: .jpg .jpeg .png
/// .bmp .tif .tiff in any case.
std::vector<std::string> list_image_files(const std::string& folder);

}  // namespace cpplus
