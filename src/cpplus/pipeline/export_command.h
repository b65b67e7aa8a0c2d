#pragma once

#include <cstddef>
#include <string>

#include "cpplus/cloud/voxel_map.h"
#include "cpplus/colorize/view_sampler.h"
#include "cpplus/geometry/pinhole_views.h"
#include "cpplus/pipeline/map_tracks.h"
#include "cpplus/render/surface_view.h"

namespace cpplus {

struct ExportCommandOptions {
  /// colmap-text, colmap-bin, undistorted, 3dgs, nerfstudio, depth, normals, potree, tum or kitti. Required.
  std::string format;
  /// COLMAP model folder with the images' cameras and poses. Required, but for potree only with local_origin.
  std::string poses;
  /// Folder to be made, new or empty. Required.
  std::string out;
  /// Map (.pcd .ply .las .vox). Not for tum and kitti; undistorted goes without points if there is none.
  std::string map;
  /// Folder of the images. Not for depth, normals, potree, tum and kitti.
  std::string images;
  /// Text file with the instant of each image, "NAME SECONDS" a line: tum needs it, kitti sorts by it; "" = none.
  std::string stamps;
  /// What a depth map holds: "z", the distance along the optical axis, or "range", along the ray of the pixel.
  std::string depth_kind = "z";
  /// Depth and normal maps as OpenEXR with 32-bit floats instead of 16-bit PNG.
  bool exr = false;
  /// Moves everything by whole metres so that the cameras are near zero; origin.txt says by how much.
  bool local_origin = false;
  /// Of undistorted images. [1, 100]
  int jpeg_quality = 96;
  MapTrackOptions tracks;
  ViewSamplingOptions sampling;
  PinholeViewOptions undistort;
  SurfaceViewOptions surface;
  VoxelMapOptions voxel_map;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("format", format,
            "colmap-text, colmap-bin, undistorted, 3dgs, nerfstudio, depth, normals, potree, tum or kitti. Required.");
    visitor("poses", poses,
            "COLMAP model folder with the images' cameras and poses. potree needs it for local_origin only.");
    visitor("out", out, "Folder to be made, new or empty. Required.");
    visitor("map", map, "Map (.pcd .ply .las .vox). Not for tum, kitti; undistorted may go without.");
    visitor("images", images, "Folder of the images. Not for depth, normals, potree, tum and kitti.");
    visitor("stamps", stamps, "File with the instant of each image, NAME SECONDS a line, for tum and kitti.");
    visitor("depth_kind", depth_kind, "Depth maps hold z (along the optical axis) or range (along the ray).");
    visitor("exr", exr, "Depth and normal maps as EXR with 32-bit floats instead of 16-bit PNG.");
    visitor("local_origin", local_origin, "Move everything by whole metres to near zero; origin.txt says how far.");
    visitor("jpeg_quality", jpeg_quality, "Of undistorted images. [1, 100]");
    tracks.visit(visitor);
    visitor.group("sampling", sampling);
    visitor.group("undistort", undistort);
    visitor.group("surface", surface);
    visitor.group("voxel_map", voxel_map);
  }
};

struct ExportSummary {
  size_t num_images = 0;   // written or described; the faces of a panorama count one by one
  size_t num_skipped = 0;  // images of the model that are missing or cannot be used
  size_t num_points = 0;
  size_t num_observations = 0;
};

/// Writes poses, images and map in the format of another program (docs/export.md). The folder appears whole or not at
/// all. An image that is missing, broken or of another size than its camera is left out with a warning. Throws Error
/// naming file or camera for anything else that cannot be read, written or expressed in the format.
ExportSummary run_export(const ExportCommandOptions& options);

}  // namespace cpplus
