#pragma once

#include <Eigen/Core>
#include <string>

#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

/// What the viewer shows besides the cloud.
struct ViewPage {
  std::string title;
  std::string report_json;  // of refine
  SparseModel coarse;
  SparseModel refined;                                      // images that are missing here keep their coarse pose
  Eigen::Vector3d origin_in_map = Eigen::Vector3d::Zero();  // of the tiles
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  size_t num_points = 0;
};

/// "photos/000007.jpg": the photo of an image of report.json, by its place there.
std::string photo_path(size_t image);

/// The page's data as a script that sets window.cpplusView: up and origin, cameras with a grid of bearings (a photo is
/// drawn on it, whatever the lens), and of each image verdict, expected shift and its poses before and after as
/// qx qy qz qw x y z, map_from_camera, relative to the origin. Images that the coarse model does not name are left out.
/// Throws Error for a report_json that is not one.
std::string view_page_script(const ViewPage& page);

}  // namespace cpplus
