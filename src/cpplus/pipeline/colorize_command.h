#pragma once

#include <string>

#include "cpplus/colorize/colorize.h"

namespace cpplus {

struct ColorizeCommandOptions {
  /// Point cloud to be coloured.
  std::string map;
  /// Folder of the images.
  std::string images;
  /// COLMAP model folder with the cameras and the poses of the images in the map.
  std::string poses;
  /// Coloured cloud to be written (.ply, .pcd, .las).
  std::string out;
  /// Folder for renderings of the coloured cloud from each image's pose; "" = none.
  std::string debug_images;
  ColorizeOptions colorize;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("map", map, "Point cloud to be coloured.");
    visitor("images", images, "Folder of the images.");
    visitor("poses", poses, "COLMAP model folder with the poses of the images in the map.");
    visitor("out", out, "Coloured cloud to be written (.ply, .pcd, .las).");
    visitor("debug_images", debug_images, "Folder for renderings of the cloud beside the images; empty = none.");
    visitor.group("colorize", colorize);
  }
};

struct ColorizeSummary {
  size_t num_points = 0;
  size_t num_colored = 0;
  size_t num_images = 0;          // that colours were taken from
  size_t num_missing_images = 0;  // named by the model, but not in the folder
};

/// Reads the map and the model, colours the map's points from the images (decoded one after the other) and writes the
/// cloud. Images without a pose and poses without an image are warned of. Throws Error naming the file for
/// unreadable input.
ColorizeSummary colorize_map(const ColorizeCommandOptions& options);

}  // namespace cpplus
