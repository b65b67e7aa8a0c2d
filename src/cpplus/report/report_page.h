#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/sparse_model.h"
#include "cpplus/report/top_view.h"

namespace cpplus {

/// What the page shows, besides report.json.
struct ReportPage {
  std::string title;
  std::string report_json;  // as refine_report_json() gives it
  SparseModel coarse;
  SparseModel refined;  // images that are missing here keep their coarse pose
  TopView view{Eigen::Vector3d::UnitZ()};
  TopViewBounds floor_plan_bounds;
  bool has_floor_plan = false;
  std::vector<bool> has_pictures;  // by image of report.json
};

/// File names of an image's pictures below the page's folder, by its place in report.json.
struct PicturePaths {
  std::string thumbnail, before, after;
};
PicturePaths picture_paths(size_t image);

/// The page's data as a script that sets window.cpplusReport: figures of every image, its places in the top view before
/// and after (m), the directions it looks in, and the ellipse of one standard deviation of its place (half axes in m,
/// angle in rad), how far the pose moved (m, degrees), and the options. Throws Error for a report_json that is not one.
std::string report_page_script(const ReportPage& page);

}  // namespace cpplus
