#pragma once

#include <functional>
#include <string>

#include "cpplus/core/options.h"

namespace cpplus {

struct ViewCommandOptions {
  /// Coloured point cloud or voxel map file; "" = one in the folder, else `coloured.*` beside the result, else the map.
  std::string cloud;
  /// Images and coarse model that `refine` had; "" = where report.json says that they are.
  std::string images;
  std::string poses;
  /// Port of the server on 127.0.0.1; 0 = any that is free. [0, 65535]
  int port = 0;
  /// Writes the viewer with all photos into this folder, for a web server, and ends; "" = serves it.
  std::string export_to;
  /// Longer side of the photos, pixels. [64, 8192]
  int photo_size_px = 1600;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("cloud", cloud, "Coloured cloud; empty = coloured.ply, .pcd, .las or .vox with the result, else its map.");
    visitor("images", images, "Folder of the images; empty = where report.json says.");
    visitor("poses", poses, "COLMAP model folder of the coarse poses; empty = where report.json says.");
    visitor("port", port, "Port of the server on 127.0.0.1; 0 = any that is free. [0, 65535]");
    visitor("export", export_to, "Write the viewer and all photos to this folder and end; empty = serve it.");
    visitor("photo_size_px", photo_size_px, "Longer side of the photos, pixels. [64, 8192]");
  }
};

/// Writes the viewer of a result of `refine` (a folder with report.json, or one with such a folder in it) and serves it
/// on 127.0.0.1 until the program is stopped; `on_ready` gets the address. The tiles of the cloud are kept in view/ in
/// the result's folder and made anew when the cloud has changed. With export_to `on_ready` gets that folder. Throws
/// Error naming the file that is missing or broken, or the port that is taken.
void view_command(const std::string& result_folder, const ViewCommandOptions& options,
                  const std::function<void(const std::string& address)>& on_ready);

}  // namespace cpplus
