#pragma once

#include <string>

#include "cpplus/core/options.h"

namespace cpplus {

struct ReportCommandOptions {
  /// Point cloud, images and coarse model that `refine` had; "" = where report.json says that they are.
  std::string map;
  std::string images;
  std::string poses;
  /// Folder of the page; "" = report/ in the result's folder.
  std::string out;
  /// Draws the map's edges over each image, before and after. Without it neither map nor images are read.
  bool pictures = true;
  /// Longer side of these pictures, pixels. [64, 8192]
  int picture_size_px = 1200;

  void validate() const;
  template <typename Visitor>
  void visit(Visitor& visitor) {
    visitor("map", map, "Point cloud that refine had; empty = where report.json says.");
    visitor("images", images, "Folder of the images; empty = where report.json says.");
    visitor("poses", poses, "COLMAP model folder of the coarse poses; empty = where report.json says.");
    visitor("out", out, "Folder of the page; empty = report/ in the result's folder.");
    visitor("pictures", pictures, "Draw the map's edges over each image, before and after.");
    visitor("picture_size_px", picture_size_px, "Longer side of these pictures, pixels. [64, 8192]");
  }
};

struct ReportSummary {
  std::string page;  // the file to open
  size_t num_images = 0;
  size_t num_pictures_made = 0;
  size_t num_pictures_kept = 0;  // made by an earlier run on the same result
};

/// Makes a static page about a result of `refine` (a folder with report.json and sparse/, or one with such a folder in
/// it), to be opened from disk. Pictures that an earlier run made of the same result stay. An image that cannot be read
/// has no picture. Throws Error naming the file that is missing or broken.
ReportSummary report_command(const std::string& result_folder, const ReportCommandOptions& options);

}  // namespace cpplus
