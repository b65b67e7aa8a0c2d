#pragma once

#include <string>

#include "cpplus/pipeline/feature_store.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

struct RefineCommandOptions {
  /// Point cloud of the map (.pcd .ply .las), or its voxel map (.vox).
  std::string map;
  /// Folder of the images.
  std::string images;
  /// COLMAP model folder with cameras and coarse poses in the map.
  std::string poses;
  /// Folder for sparse/ and report.json.
  std::string out;
  /// Folder for overlays of the map's edges before and after, one an image; "" = none.
  std::string debug_images;
  /// Text file with the instant of each image, "NAME SECONDS" a line; "" = the model's order counts as the order in
  /// time.
  std::string stamps;
  /// TUM file with poses of the LiDAR (map_from_lidar), whose velocity the time offset is found by; "" = the coarse
  /// poses do. Takes stamps.
  std::string trajectory;
  /// cp_plus, or a simpler method for comparison (pipeline/refine_baselines.h): lines, nid, none. These solve no images
  /// together.
  std::string method = "cp_plus";
  /// Solves all images together after each has been refined on its own; one whose pose is doubtful is first looked for
  /// again where the others expect it.
  bool joint = true;
  /// Leaves images that were not refined out of the output model.
  bool only_refined = false;
  /// Folder where the voxel map of a point cloud is kept for later runs (docs/index.md); "" = none.
  std::string cache;
  /// The planes and edges of a voxel map are kept in the folder MAP.vox.features for later runs (docs/index.md).
  bool keep_features = true;
  FeatureStoreOptions tiles;
  /// Images with more points of the map around them than this are worked on in groups that lie near each other, one at
  /// a time; some 60 bytes of memory a point. [1, inf)
  int max_group_points = 16'000'000;
  RefineImagesOptions stages;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("map", map, "Point cloud of the map (.pcd .ply .las), or its voxel map (.vox).");
    visitor("images", images, "Folder of the images.");
    visitor("poses", poses, "COLMAP model folder with cameras and coarse poses in the map.");
    visitor("out", out, "Folder for the refined model (sparse/) and report.json.");
    visitor("debug_images", debug_images, "Folder for overlays of the map's edges before and after; empty = none.");
    visitor("stamps", stamps, "File with the instant of each image, NAME SECONDS a line; empty = the model's order.");
    visitor("trajectory", trajectory,
            "TUM poses of the LiDAR, for the time offset; empty = the coarse poses. Takes stamps.");
    visitor("method", method, "cp_plus, or for comparison lines, nid or none, which look at each image alone.");
    visitor("joint", joint, "Solve all images together after each has been refined on its own.");
    visitor("only_refined", only_refined, "Leave images that were not refined out of the output model.");
    visitor("cache", cache, "Folder where the voxel map of a point cloud is kept for later runs; empty = none.");
    visitor("keep_features", keep_features, "Keep planes and edges of a voxel map beside it, for later runs.");
    visitor.group("tiles", tiles);
    visitor("max_group_points", max_group_points,
            "Images with more points around them are worked on in groups, one at a time; some 60 bytes a point.");
    stages.visit(visitor);
  }
};

struct RefineSummary {
  size_t num_images = 0;
  size_t num_refined = 0;
  size_t num_kept_coarse = 0;
  size_t num_blurred = 0;
  size_t num_outside_map = 0;
  size_t num_unreadable = 0;
};

/// Reads the map and the coarse poses, refines each image and writes OUT/sparse (COLMAP text, every input image unless
/// only_refined) and OUT/report.json. One bad image does not stop the others. Throws Error naming the file for
/// unreadable input, and when no image could be read at all.
RefineSummary refine_command(const RefineCommandOptions& options);

}  // namespace cpplus
