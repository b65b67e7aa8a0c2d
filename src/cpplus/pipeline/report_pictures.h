#pragma once

#include <string>
#include <vector>

#include "cpplus/pipeline/grouped_features.h"
#include "cpplus/pipeline/refine_result.h"

namespace cpplus {

/// Which pictures of a result there are in a folder, and which are to be made. By image of report.json.
struct PicturePlan {
  std::vector<size_t> kept;
  std::vector<size_t> missing;
};

/// Looks which images have a file to be drawn on, and which have their pictures (picture_paths() in report_page.h) from
/// an earlier run on the same result. Pictures of another result or size are removed.
PicturePlan plan_pictures(const RefineResult& result, const std::string& folder, int picture_size_px);

/// Draws the map's edges that each image should see over it, by its coarse and by its refined pose, and makes a
/// thumbnail. `features`: those of result.coarse. Returns the images for which that worked; the others are warned of.
std::vector<size_t> draw_pictures(const RefineResult& result, GroupedFeatures* features,
                                  const std::vector<size_t>& images, const std::string& folder, int picture_size_px);

}  // namespace cpplus
