#pragma once

#include <cstddef>
#include <string>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/colorize/colorize.h"
#include "cpplus/evaluate/image_difference.h"

namespace cpplus {

struct ColorizeCommandOptions {
  /// Point cloud to be coloured (.pcd .ply .las), or its voxel map (.vox). Required.
  std::string map;
  /// Folder of the images. Required.
  std::string images;
  /// COLMAP model folder with the images' cameras and poses. Required.
  std::string poses;
  /// Coloured cloud to be written; the extension gives the format. Required.
  std::string out;
  /// Folder for a picture an image: the photo beside the coloured cloud from its pose; "" = none.
  std::string debug_images;
  /// Every how many images one gives no colour and is foretold by the coloured cloud instead; 0 = none. [0, inf), not 1
  int hold_out = 0;
  /// COLMAP model folder with better poses of the held-out images, to foretell them from; "" = `poses`.
  std::string hold_out_poses;
  /// JSON file for gains, vignetting and how well held-out images are foretold; "" = none.
  std::string report;
  /// Folder where the voxel map of a point cloud is kept for later runs (docs/index.md); "" = none.
  std::string cache;
  /// Points of the map that are coloured at a time, at most: memory grows with it, not with the map. [1, inf)
  int max_part_points = 8'000'000;
  VoxelMapOptions voxel_map;
  ColorizeOptions color;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("map", map, "Point cloud to be coloured (.pcd .ply .las), or its voxel map (.vox). Required.");
    visitor("images", images, "Folder of the images. Required.");
    visitor("poses", poses, "COLMAP model folder with the images' cameras and poses. Required.");
    visitor("out", out, "Coloured cloud to be written; the extension (.pcd .ply .las) gives the format. Required.");
    visitor("debug_images", debug_images,
            "Folder for pictures of each photo beside the coloured cloud from its pose; empty = none.");
    visitor("hold_out", hold_out,
            "Every how many images one gives no colour and is compared with a rendering instead; 0 = none.");
    visitor("hold_out_poses", hold_out_poses,
            "COLMAP model folder with the poses held-out images are rendered from; empty = those of `poses`.");
    visitor("report", report, "JSON file for gains, vignetting and the held-out images; empty = none.");
    visitor("cache", cache, "Folder where the voxel map of a point cloud is kept for later runs; empty = none.");
    visitor("max_part_points", max_part_points, "Points coloured at a time, at most; memory grows with them. [1, inf)");
    visitor.group("voxel_map", voxel_map);
    visitor.group("color", color);
  }
};

struct ColorizeSummary {
  size_t num_points = 0;
  size_t num_colored = 0;    // points that at least one image shows
  size_t num_images = 0;     // images that gave colours
  size_t num_skipped = 0;    // images of the model that are missing or cannot be used
  size_t num_held_out = 0;   // without blurred ones
  ImageDifference held_out;  // of these together
};

/// Reads map, poses and images (one at a time, each once for every part of the map that it looks at, and when it is
/// drawn), colours the points, and writes the cloud.
/// An image that is missing, broken or of another size than its camera is skipped with a warning. Throws Error naming
/// the file for anything else that cannot be read or written, and where no image sees a point of the map; nothing is
/// written then.
ColorizeSummary run_colorize(const ColorizeCommandOptions& options);

}  // namespace cpplus
